"""Frontier exploration of the live OctoMap: always travel to the nearest column that is unknown in the map.

Yamauchi, "A frontier-based approach for autonomous exploration", CIRA 1997, applied to columns of the map: a column is
known if any voxel in it is occupied (at least the bed), and closed if an occupied voxel is too high for the vehicle to
pass over. Paths lead over known, open columns, so the map alone avoids obstacles; the sonar still looks ahead.
Exploration ends when no unknown column within the bound is adjacent to a reachable one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from uwsim.mapping import OccupancyMap
from uwsim.missions.lanes import LEAST_FLOWN
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.cells import Cell, Cells, nearest
from uwsim.missions.planners.live_map import LOOK_PERIOD_S, LiveMap
from uwsim.missions.planners.unknown_water import find_bed
from uwsim.missions.planners.wayfinder import PASSABLE_Z_M, TURN_FIRST_RAD, Wayfinder
from uwsim.missions.steps import Steps, StoppedError
from uwsim.navigation.control.autopilot import wrap_angle

STUCK_S = 30.0  # added to a path's time limit, which is otherwise four times its nominal duration


@dataclass(frozen=True, eq=False)
class Explored:
    """The outcome of `explore`. map: built in flight. known_m2: area of the known columns within the bound.

    given_up: centres of the columns that remained unknown.
    """

    map: OccupancyMap
    known_m2: float
    given_up: tuple[tuple[float, float], ...]


def explore(
    vehicle: OwnVehicle,
    bound_m: float,
    *,
    altitude_m: float = 4.0,
    speed_m_s: float = 0.6,
    resolution_m: float = 0.5,
    cell_m: float = 2.0,
) -> Steps[Explored]:
    """Explore all water that can be reached within bound_m of the start, until the map contains all of it.

    resolution_m: resolution of the live map. cell_m: edge length of a column. Logs `frontier` for each target, and also
    `given_up` and `explored`. Raises ValueError for invalid arguments, StoppedError if the vehicle cannot continue, or
    if more than 5 % of the columns found were given up.
    """
    if not resolution_m <= cell_m <= bound_m < math.inf:
        raise ValueError(
            f"cell_m = {cell_m} m: must be at least resolution_m = {resolution_m} m and at most bound_m = {bound_m} m"
        )
    start = vehicle.pose.position_world_m
    cells = Cells((float(start[0]), float(start[1])), 0.0, cell_m)
    live = LiveMap(vehicle, resolution_m, cells)
    lookout = Wayfinder(vehicle, altitude_m, speed_m_s, on_ping=live.add)
    yield from lookout.tilt()
    yield from find_bed(vehicle)
    yield from lookout.steer(vehicle.pose.yaw_rad, (0.0, 0.0))
    search = _Search(lookout, live, cells, bound_m)
    while (way := search.way()) is not None:
        yield from search.go(way)
    known_m2 = cell_m**2 * sum(search.inside(cell) for cell in live.tops_m)
    vehicle.log("explored", known_m2=known_m2, given_up=len(search.given_up), bound_m=bound_m)
    given_up_m2 = cell_m**2 * len(search.given_up)
    if known_m2 < LEAST_FLOWN * (known_m2 + given_up_m2):
        raise StoppedError(f"{given_up_m2:.0f} m2 had to be given up, {known_m2:.0f} m2 are known")
    return Explored(live.map, known_m2, tuple(cells.middle_m(cell) for cell in search.given_up))


class _Search:
    """The progress of `explore`.

    given_up: columns that remain unknown. _closed: known columns that cannot be entered for other reasons.
    """

    def __init__(self, lookout: Wayfinder, live: LiveMap, cells: Cells, bound_m: float) -> None:
        self._lookout, self._vehicle, self._live, self._cells = lookout, lookout.vehicle, live, cells
        self._bound_m = bound_m
        self.given_up: dict[Cell, None] = {}
        self._closed: set[Cell] = set()
        self._here: Cell = (0, 0)  # the last known open column that the vehicle visited

    def inside(self, cell: Cell) -> bool:
        return math.dist(self._cells.middle_m(cell), self._cells.middle_m((0, 0))) <= self._bound_m

    def _unknown(self, cell: Cell) -> bool:
        return cell not in self._live.tops_m and cell not in self.given_up and self.inside(cell)

    def _open(self, cell: Cell) -> bool:
        top_m = self._live.tops_m.get(cell, math.inf)
        return top_m < PASSABLE_Z_M and cell not in self._closed and self.inside(cell)

    def way(self) -> list[Cell] | None:
        """Return the path over open columns to the nearest unknown column."""
        return nearest(self._here, self._unknown, [cell for cell in self._live.tops_m if self._open(cell)])

    def go(self, way: list[Cell]) -> Steps[None]:
        """Follow a path until its last column is known; otherwise give up that column or close the blocking one."""
        vehicle, frontier = self._vehicle, way[-1]
        vehicle.log("frontier", position_m=list(self._cells.middle_m(frontier)), cells_away=len(way) - 1)
        end_s = vehicle.time_s + STUCK_S + 4.0 * len(way) * self._cells.edge_m / self._lookout.speed_m_s
        for cell in way:
            middle = self._cells.middle_m(cell)
            while math.dist(vehicle.pose.position_world_m[:2], middle) > 0.5 * self._cells.edge_m:
                if not self._unknown(frontier):
                    return
                if vehicle.time_s > end_s:
                    return self._give_up(frontier)
                yield from self._lookout.towards(middle)
                at = self._cells.cell_of(vehicle.pose.position_world_m)
                if self._open(at):
                    self._here = at
                if self._lookout.must_stop and self._facing(middle):
                    return self._close(cell, frontier)
        end_s = vehicle.time_s + 2.0 * LOOK_PERIOD_S
        while self._unknown(frontier):  # the vehicle is above the column, so the altimeter sees the bed, if any
            if vehicle.time_s > end_s:
                return self._give_up(frontier)
            yield from self._lookout.towards(middle)

    def _facing(self, point_m: tuple[float, float]) -> bool:
        x, y, _ = self._vehicle.pose.position_world_m.tolist()
        off_rad = wrap_angle(math.atan2(point_m[1] - y, point_m[0] - x) - self._vehicle.pose.yaw_rad)
        return abs(off_rad) < TURN_FIRST_RAD

    def _close(self, cell: Cell, frontier: Cell) -> None:
        """Close the column that the vehicle was heading for, or give it up if it is the unknown one."""
        if cell in (frontier, self._here):
            self._give_up(frontier)
        else:
            self._closed.add(cell)
            self._vehicle.log("closed", position_m=list(self._cells.middle_m(cell)), reason="too high ahead")

    def _give_up(self, frontier: Cell) -> None:
        self.given_up[frontier] = None
        self._vehicle.log("given_up", position_m=list(self._cells.middle_m(frontier)))
