"""How much was flown of the lanes of a flight, lane by lane, by the log of its missions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from uwsim.missions.lane_lengths import LANE_FLOWN, LANES_FLOWN, flown_text
from uwsim.missions.own_vehicle import Event


class LanesFlown(NamedTuple):
    """Planned lanes, and how much of them was flown. lanes: their number. each: every lane that was begun or given up.

    An item of `each` has vehicle, number, flown_m, planned_m and, for a lane cut short, because.
    """

    lanes: int
    flown_m: float
    planned_m: float
    each: list[dict[str, Any]]

    @property
    def cut_short(self) -> list[dict[str, Any]]:
        """The items of lanes that were cut short."""
        return [lane for lane in self.each if "because" in lane]

    def rows(self) -> list[tuple[str, str]]:
        """Return rows of (name, value with unit) for tables."""
        percent, _, lengths = flown_text(self.flown_m, self.planned_m).partition(" of the planned lanes ")
        rows = [("lanes flown", f"{lengths.strip('()')}, {percent}")]
        return [*rows, ("lanes cut short", f"{len(cut)} of {self.lanes}")] if (cut := self.cut_short) else rows


def lanes_flown(events: Iterable[Event]) -> LanesFlown | None:
    """Return what the missions of a log flew of their lanes; None if none flew lanes."""
    events = list(events)
    totals = [event.values for event in events if event.name == LANES_FLOWN]
    if not totals:
        return None
    each = [{"vehicle": event.vehicle, **event.values} for event in events if event.name == LANE_FLOWN]
    lanes, flown_m, planned_m = (sum(total[key] for total in totals) for key in ("lanes", "flown_m", "planned_m"))
    return LanesFlown(lanes, flown_m, planned_m, each)
