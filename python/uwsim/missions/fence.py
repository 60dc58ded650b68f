"""Fences: zones that a mission must stay in or out of, as ground stations draw them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.polygon import inside, is_crossed
from uwsim.mapping.files.georeference import Place
from uwsim.missions.items import CHORDS, CIRCLE, JUMP, KINDS, RETURN
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.steps import Steps, StoppedError

RETURN_POINT, POLYGON_IN, POLYGON_OUT, CIRCLE_IN, CIRCLE_OUT = range(5000, 5005)  # MAV_CMD_NAV_FENCE_...
BREACHED = "fence_breached"
"""The event in a mission's log."""


class Zone(NamedTuple):
    """A zone of a fence, to stay inside of, or outside. corners: latitude, longitude [deg]; of a circle, its centre."""

    is_inclusion: bool
    corners: tuple[tuple[float, float], ...]
    radius_m: float = 0.0


class Fence:
    """Zones in a world. A place is within the fence if it is inside all zones of inclusion and none of exclusion.

    So does ArduPilot without the option of a union (AC_PolyFence_loader.cpp, `breached`). A place on a zone's edge may
    count as either. Depths have no effect.
    """

    def __init__(self, zones: Sequence[Zone], place: Place) -> None:
        self.zones = tuple(zones)
        self._place = place

    @cached_property
    def _corners_m(self) -> list[Floats]:
        return [np.array([self._place.world_m(*at, 0.0)[:2] for at in zone.corners]) for zone in self.zones]

    def breach(self, start_m: Floats, end_m: Floats | None = None) -> str | None:
        """Return how a place in the world, or the line to a second one, leaves the fence; None if it does not."""
        start = np.asarray(start_m, np.float64)[:2]
        ends = np.array([start] if end_m is None else [start, np.asarray(end_m, np.float64)[:2]])
        for number, (zone, corners_m) in enumerate(zip(self.zones, self._corners_m, strict=True), 1):
            if zone.radius_m:
                nearest_m, farthest_m = _distances_m(corners_m[0], ends[0], ends[-1])
                is_in, is_out = farthest_m <= zone.radius_m, nearest_m > zone.radius_m
                shape = f"circle of {zone.radius_m:g} m"
            else:
                are_in, crosses = inside(ends, corners_m), is_crossed(corners_m, ends[0], ends[-1])
                is_in, is_out = bool(are_in.all()) and not crosses, not (are_in.any() or crosses)
                shape = f"polygon with {len(corners_m)} corners"
            if not (is_in if zone.is_inclusion else is_out):
                verb = "leaves" if zone.is_inclusion else "enters"
                return f"{verb} zone {number} of the fence, a {shape} to stay {'in' if zone.is_inclusion else 'out of'}"
        return None

    def refusal(self, items: Iterable[Any], launch_m: Floats | None = None) -> str | None:
        """Return which item leads where out of the fence, on the legs between items; None if none does.

        launch_m: where the mission begins, and where items return to, if it is known.
        """
        for number, before, after in legs_m(list(items), self._place, launch_m):
            if (why := self.breach(before, after)) is not None:
                leg = f"({after[0]:.1f}, {after[1]:.1f}) m"
                if not np.array_equal(before[:2], after[:2]):
                    leg = f"the leg from ({before[0]:.1f}, {before[1]:.1f}) to {leg}"
                return f"mission item {number}: {leg} {why}"
        return None

    def kept(self, vehicle: OwnVehicle, steps: Steps[Any]) -> Steps[Any]:
        """Fly steps. Raises StoppedError, after an event in the log, once the vehicle is not within the fence."""
        try:
            for pause in steps:
                yield pause
                here = vehicle.pose.position_world_m
                if (why := self.breach(here)) is not None:
                    x, y, z = (round(float(part), 1) for part in here)
                    vehicle.log(BREACHED, x_m=x, y_m=y, z_m=z, why=why)
                    raise StoppedError(f"the vehicle at ({x}, {y}) m {why}")
        finally:
            steps.close()


def legs_m(items: Sequence[Any], place: Place, launch_m: Floats | None) -> Iterator[tuple[int, Floats, Floats]]:
    """Yield an item's number and both ends of each line that leads to it; twice the place of a first one."""
    before = launch_m

    def to(number: int, point: Floats) -> tuple[int, Floats, Floats]:
        return number, (point if before is None else before), point

    for item in items:
        kind = KINDS.get(item.command)
        is_jump = item.command == JUMP and 1 <= item.param1 <= len(items)
        aim = items[int(item.param1) - 1] if is_jump else item
        if item.command == RETURN and launch_m is not None:
            yield to(item.seq, launch_m)
            before = launch_m
        elif kind is not None and (kind.is_placed or is_jump) and (aim.x or aim.y):
            point = place.world_m(1e-7 * aim.x, 1e-7 * aim.y, 0.0)
            if item.command != CIRCLE:
                yield to(item.seq, point)
                before = before if is_jump else point
                continue
            angles = np.linspace(0.0, math.tau, CHORDS + 1)
            round_it = point[:2] + abs(item.param3) * np.column_stack([np.cos(angles), np.sin(angles)])
            yield from ((item.seq, start, end) for start, end in pairwise(round_it))
            before = None


def _distances_m(centre: Floats, start: Floats, end: Floats) -> tuple[float, float]:
    """Return the least and the greatest distance of a line from a point."""
    along = end - start
    share = float((centre - start) @ along) / max(float(along @ along), 1e-12)
    nearest = start + min(max(share, 0.0), 1.0) * along
    return math.dist(nearest, centre), max(math.dist(start, centre), math.dist(end, centre))


def zones_of(items: Iterable[Any]) -> tuple[Zone, ...]:
    """Return the zones of a fence's items, whose polygons state the count of corners in each. Raises ValueError."""
    zones: list[Zone] = []
    corners: list[tuple[float, float]] = []
    for item in items:
        at = 1e-7 * item.x, 1e-7 * item.y
        if corners and item.command not in (POLYGON_IN, POLYGON_OUT):
            raise ValueError(f"geofence item {item.seq}: the polygon before it lacks corners")
        if item.command in (CIRCLE_IN, CIRCLE_OUT):
            if not 0 < item.param1 <= 1e5:
                raise ValueError(f"geofence item {item.seq}: radius = {item.param1:g} m: must be in (0, 1e+05]")
            zones.append(Zone(item.command == CIRCLE_IN, (at,), float(item.param1)))
        elif item.command in (POLYGON_IN, POLYGON_OUT):
            if not 3 <= item.param1 <= 1000:
                raise ValueError(f"geofence item {item.seq}: {item.param1:g} corners: must be in [3, 1000]")
            corners.append(at)
            if len(corners) >= item.param1:
                zones.append(Zone(item.command == POLYGON_IN, tuple(corners)))
                corners = []
    if corners:
        raise ValueError(f"geofence: its last polygon has {len(corners)} corners, less than its items state")
    return tuple(zones)
