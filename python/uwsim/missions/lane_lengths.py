"""The lengths of lanes flown and planned: their events in a mission's log, and when a survey is not complete."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

LANE_FLOWN, LANES_FLOWN = "lane_flown", "lanes_flown"
"""The events at the end of each lane and of all."""
LEAST_FLOWN = 0.95
"""The share of the planned length below which a mission over lanes is not complete."""


@dataclass(frozen=True)
class LaneEnd:
    """The end of a lane: how much of it was flown, and why no more; "" if it was flown to its end."""

    flown_m: float
    because: str


def lane_values(number: int, planned_m: float, end: LaneEnd) -> dict[str, float | str]:
    """Return the values of the event LANE_FLOWN."""
    why = {"because": end.because} if end.because else {}
    return {"number": number, "flown_m": round(end.flown_m, 2), "planned_m": round(planned_m, 2), **why}


def not_flown_because(flown_m: float, planned_m: float, ended: Iterable[LaneEnd]) -> str:
    """Return a clause that states how much was flown, and why lanes were cut short."""
    reasons = Counter(end.because for end in ended if end.because)
    cut = "; ".join(f"{reason} on {count} of the lanes" for reason, count in reasons.most_common())
    return f"only {flown_text(flown_m, planned_m)} was flown{f': {cut}' if cut else ''}"


def flown_text(flown_m: float, planned_m: float) -> str:
    """Return text such as `93.2 % of the planned lanes (178 of 191 m)`, never rounded up."""
    percent = math.floor(1000.0 * flown_m / planned_m) / 10.0 if planned_m > 0.0 else 100.0
    return f"{percent:g} % of the planned lanes ({flown_m:,.0f} of {planned_m:,.0f} m)"
