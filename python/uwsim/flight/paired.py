"""Paired comparison of missions: differences between flights of the same seed, with exact intervals of their median."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from uwsim.flight.compare import Row

MORE_IS_BETTER = {
    "time_s": False, "path_m": False, "effort_s": False, "battery_percent": False, "collisions": False,
    "estimate_rms_m": False, "off_target_m": False, "seen_m2": True, "half_seen_s": False, "map_coverage": True,
    "map_error_m": False,
}  # fmt: skip
"""The values of a row that are compared, and whether more of them is better."""
ENOUGH = 0.95
"""The share of another flight's achievement from which on a flight has achieved as much."""
LEVEL = 0.95
LEAST_FOR_INTERVAL = 6
"""Seeds from which on an interval exists: 2 (1/2)^n < 1 - LEVEL."""


@dataclass(frozen=True)
class Pair:
    """How a mission differs from the first one in a value, over the seeds that both have flown.

    median: of the differences, positive if the mission's value is larger. low, high: 95 % interval of that median; NaN
    with fewer than 6 seeds. wins, losses: seeds for which the mission is better, and worse; the rest are ties. Where
    less is better, a flight that achieved less is not better: one that ended early while the other did not, or that saw
    less than 95 % of the other's area or, if there is a target, was farther from it.
    """

    mission: str
    against: str
    value: str
    seeds: int
    median: float
    low: float
    high: float
    wins: int
    losses: int


def paired(rows: Sequence[Row], values: Iterable[str] = MORE_IS_BETTER) -> list[Pair]:
    """Compare every mission with the first one, in each value that is known for all of their common seeds.

    The interval is that of order statistics, which makes no assumption about the distribution (Conover, Practical
    Nonparametric Statistics, 1999, 3.2; scipy.stats.quantile_test).
    """
    missions = list(dict.fromkeys(row.mission for row in rows))
    flown: dict[str, dict[int, Row]] = {name: {} for name in missions}
    for row in rows:
        flown[row.mission][row.seed] = row
    found = []
    for name in missions[1:]:
        seeds = [seed for seed in flown[missions[0]] if seed in flown[name]]
        for value in values:
            pairs = [(flown[name][s], flown[missions[0]][s]) for s in seeds]
            gaps = np.array([getattr(one, value) - getattr(other, value) for one, other in pairs])
            if len(gaps) and np.isfinite(gaps).all():
                found.append(_pair(name, missions[0], value, gaps, pairs))
    return found


def _achieved_as_much(one: Row, other: Row) -> bool:
    """Return whether a flight achieved as much as another; see Pair."""
    if one.ended_early and not other.ended_early:
        return False
    if math.isfinite(one.off_target_m) and math.isfinite(other.off_target_m):
        return ENOUGH * one.off_target_m <= other.off_target_m
    return one.seen_m2 >= ENOUGH * other.seen_m2


def _pair(mission: str, against: str, value: str, gaps: np.ndarray, pairs: Sequence[tuple[Row, Row]]) -> Pair:
    from scipy.stats import quantile_test  # imported here: scipy.stats takes half a second

    low = high = float("nan")
    if len(gaps) >= LEAST_FOR_INTERVAL:
        low, high = quantile_test(gaps, q=0.0, p=0.5).confidence_interval(LEVEL)
    better = gaps if MORE_IS_BETTER[value] else -gaps
    fair = [MORE_IS_BETTER[value] or _achieved_as_much(*(pair if gain > 0 else pair[::-1])) for gain, pair in
            zip(better.tolist(), pairs, strict=True)]  # fmt: skip
    wins, losses = int(((better > 0) & fair).sum()), int(((better < 0) & fair).sum())
    return Pair(mission, against, value, len(gaps), float(np.median(gaps)), float(low), float(high), wins, losses)


def without_randomness(rows: Sequence[Row]) -> list[str]:
    """Return the missions whose flights are the same for all of at least two seeds."""
    flights: Mapping[str, list[tuple[object, ...]]] = {row.mission: [] for row in rows}
    for row in rows:
        flights[row.mission].append(tuple(repr(value) for key, value in asdict(row).items() if key != "seed"))
    return [name for name, each in flights.items() if len(each) > 1 and len(set(each)) == 1]
