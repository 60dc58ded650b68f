"""The levels of a cast: the samples of its way down, below the surface, each deeper than those before."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.scenario.read.cast_quantity import LATITUDE_DEG, PRESSURE, depth_at_m

MOST_LEVELS = 10_000


class Range(Protocol):
    """The lowest and the highest value, and their unit."""

    low: float
    high: float
    unit: str


Limits = Mapping[str, Range]
"""By the keys of a profile's levels."""


class Columns(NamedTuple):
    """The samples of a file. values: by the keys of levels, or PRESSURE [dbar]. lines: of text, one a sample."""

    values: dict[str, Floats]
    lines: list[int]
    notes: list[str]


@dataclass(frozen=True, eq=False)
class Cast:
    """A cast from the surface down. columns: by the keys of a profile's levels. lines: of the file, one for each level.

    lines: empty for a file that is no text. notes: what was left out or assumed.
    """

    columns: Mapping[str, Floats]
    lines: Sequence[int]
    notes: Sequence[str]


def levels_of(name: str, columns: dict[str, Floats], lines: list[int], notes: list[str], limits: Limits) -> Cast:
    """Return a cast's way down, or up if it has no other, each sample deeper than those before. Raises ValueError."""
    pressure = columns.pop(PRESSURE, None)
    if "depth_m" not in columns:
        if pressure is None:
            raise ValueError(f"{name}: has neither depth nor pressure")
        columns["depth_m"] = depth_at_m(pressure)
        notes.append(f"depths follow from pressure, as of sea water in latitude {LATITUDE_DEG:g}")
    for key in ("temperature_deg_c", "salinity_psu", "sound_speed_m_s"):
        values = columns.get(key)
        if values is None:
            continue
        empty = np.isnan(values) | (
            (values == 0.0) if key == "sound_speed_m_s" or not np.nansum(np.abs(values)) else False
        )
        columns[key] = np.where(empty, np.nan, values)
        if empty.all():
            del columns[key]
            notes.append(f"{key} has no values, or only zeros")
    if columns.keys() <= {"depth_m", "salinity_psu", "density_kg_m3"}:
        raise ValueError(f"{name}: has neither sound speed nor temperature")
    depth = columns["depth_m"]
    kept = np.arange(len(depth))
    kept = _without(kept, ~np.isnan(np.sum(list(columns.values()), axis=0)), "without a value", notes)
    kept = _without(kept, depth[kept] >= 0.0, "above the surface", notes)
    if not len(kept):
        raise ValueError(f"{name}: has no sample with all values below the surface")
    _require_in(name, columns, lines, kept, limits)
    deepest = int(np.argmax(depth[kept]))
    begin = deepest - int(np.argmin(depth[kept[: deepest + 1]][::-1]))
    ways = {"down": _deeper(kept[begin : deepest + 1], depth), "up": _deeper(kept[deepest:][::-1], depth)}
    way = "up" if len(ways["up"]) > 4 * len(ways["down"]) else "down"
    chosen = ways[way]
    if left := len(kept) - len(chosen):
        notes.append(f"the way {way} is used, without {left} samples before, after, or not deeper than one before")
    if (step := math.ceil(len(chosen) / MOST_LEVELS)) > 1:
        notes.append(f"one of {step} samples is used, since a profile has at most {MOST_LEVELS} levels")
        chosen = chosen[::step]
    return Cast(
        {key: values[chosen] for key, values in columns.items()}, [lines[k] for k in chosen] if lines else [], notes
    )


def _deeper(kept: NDArray[np.intp], depth: Floats) -> NDArray[np.intp]:
    """Return the samples that are deeper than all before."""
    deeper = np.concatenate([[True], depth[kept][1:] > np.maximum.accumulate(depth[kept])[:-1]])
    return np.asarray(kept[deeper], np.intp)


def _require_in(
    name: str, columns: dict[str, Floats], lines: list[int], kept: NDArray[np.intp], limits: Limits
) -> None:
    """Raise ValueError that names the first value outside its limits."""
    for key, limit in limits.items():
        low, high, unit = limit.low, limit.high, limit.unit
        values = columns[key][kept] if key in columns else np.zeros(0)
        wrong = np.flatnonzero(~((values >= low) & (values <= high)))
        if len(wrong):
            at = f"{name}:{lines[kept[wrong[0]]]}" if lines else f"{name}, sample {kept[wrong[0]] + 1}"
            others = f", as for {len(wrong) - 1} others" if len(wrong) > 1 else ""
            raise ValueError(
                f"{at}: {key} = {values[wrong[0]]:.7g} {unit}: must be in [{low:g}, {high:g}] {unit}{others}"
            )


def _without(kept: NDArray[np.intp], good: NDArray[np.bool_], what: str, notes: list[str]) -> NDArray[np.intp]:
    if left := int(np.count_nonzero(~good)):
        notes.append(f"{left} samples {what} are left out")
    return kept[good]
