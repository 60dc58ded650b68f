"""The adaptive lawn-mower for unknown water: with neither polygon nor chart, it turns where the sonar sees an obstacle.

It flies lanes back and forth, one line spacing apart. A lane ends where the sonar sees anything ahead that cannot be
passed over; the vehicle then side-steps and turns. If no unflown water is left next to it, it returns over flown water
to the nearest opening, and continues mowing from there. The mission is complete when no opening is left within the
bound.

The turning rule is the published simulator's; the return to openings follows BA* (Viet, Dang, Laskar and Chung, "BA*:
an online complete coverage algorithm for cleaning robots", Applied Intelligence 39, 2013), with cells of one line
spacing. The mission leaves out cells containing anything higher than the vehicle may fly, and water that is connected
only by passages narrower than about two cells.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np

from uwsim.missions.moves import steer
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.cells import Cell, Cells, nearest
from uwsim.missions.planners.wayfinder import PASSABLE_Z_M, Wayfinder
from uwsim.missions.steps import Steps, StoppedError
from uwsim.navigation.sensor_choice import height_above_bed_m

ECHOES_TO_CLOSE = 4  # this many echoes in one ping close a cell
OVERSHOOT = 1.0  # how far past the next cell to aim, in cells
STUCK_S = 30.0  # added to a cell's time limit, which is otherwise four times its nominal duration
STUCK_CELLS = 3  # after this many in a row, the vehicle itself counts as stuck
FIND_BED_S, FIND_BED_M_S = 180.0, 0.3
ARRIVED = 0.25  # distance from a cell's centre, in cells, within which the next cell is chosen
PRIORITY: tuple[Cell, ...] = ((1, 0), (-1, 0), (0, 1), (0, -1))  # along the lane first, then to the side


@dataclass(frozen=True)
class MownWater:
    """The water flown: centres (n, 2) of the cells that the vehicle visited, and of those that it found closed."""

    flown_m: tuple[tuple[float, float], ...]
    closed_m: tuple[tuple[float, float], ...]
    cell_m: float

    @property
    def flown_m2(self) -> float:
        """Area of the flown cells."""
        return len(self.flown_m) * self.cell_m**2


def mow_unknown_water(
    vehicle: OwnVehicle,
    bound_m: float,
    *,
    line_spacing_m: float | None = None,
    altitude_m: float = 4.0,
    speed_m_s: float = 0.6,
    heading_rad: float | None = None,
) -> Steps[MownWater]:
    """Mow all water that can be reached within bound_m of the start; return the flown cells.

    line_spacing_m: defaults to half of the swath width on a flat bed. heading_rad: lane direction; defaults to the
    vehicle's heading. Logs `closed` with a reason for each cell that is closed, `opening` where mowing continues, and
    `complete`. Raises ValueError for invalid arguments, StoppedError if the vehicle cannot continue, or if no cell but
    the first could be flown.
    """
    lookout = Wayfinder(vehicle, altitude_m, speed_m_s)
    spacing_m = 0.5 * lookout.swath_m if line_spacing_m is None else line_spacing_m
    if not 1.0 <= spacing_m <= bound_m < math.inf:
        raise ValueError(f"line_spacing_m = {spacing_m:g} m: must be at least 1 m and at most bound_m = {bound_m:g} m")
    yield from lookout.tilt()
    yield from find_bed(vehicle)
    mower = _Mower(lookout, bound_m, spacing_m, vehicle.pose.yaw_rad if heading_rad is None else heading_rad)
    return (yield from mower.steps())


def find_bed(vehicle: OwnVehicle) -> Steps[None]:
    """Dive on the spot until the altimeter sees the bed. Raises StoppedError if this takes too long."""
    pose, end_s = vehicle.pose, vehicle.time_s + FIND_BED_S
    while not math.isfinite(height_above_bed_m(vehicle)):
        if vehicle.time_s > end_s:
            raise StoppedError("no bed below: the altimeter has no echo")
        z_m = float(vehicle.pose.position_world_m[2])
        yield from steer(vehicle, pose.yaw_rad, (0.0, 0.0), z_m - FIND_BED_M_S)


class _Mower:
    def __init__(self, lookout: Wayfinder, bound_m: float, spacing_m: float, heading_rad: float) -> None:
        self._lookout, self._vehicle, self._bound_m = lookout, lookout.vehicle, bound_m
        start = self._vehicle.pose.position_world_m
        self._start = float(start[0]), float(start[1])
        self._cells = Cells(self._start, heading_rad, spacing_m)
        self._flown: dict[Cell, None] = {(0, 0): None}  # in order
        self._closed: dict[Cell, str] = {}
        self._stuck = 0

    def steps(self) -> Steps[MownWater]:
        cell: Cell = (0, 0)
        while (way := self._next(cell)) is not None:
            if len(way) > 2:
                self._vehicle.log("opening", position_m=list(self._cells.middle_m(way[-1])), cells_back=len(way) - 2)
            for following in way[1:]:
                if not (yield from self._enter(cell, following)):
                    break
                cell = following
        cells = self._cells
        mown = MownWater(
            tuple(cells.middle_m(c) for c in self._flown), tuple(cells.middle_m(c) for c in self._closed), cells.edge_m
        )
        closed = dict(Counter(self._closed.values()))
        if len(self._flown) == 1:
            why = ", ".join(f"{reason} in {count} cells" for reason, count in closed.items())
            raise StoppedError(f"no water around the start could be flown: {why}")
        self._vehicle.log("complete", flown_m2=mown.flown_m2, closed_cells=closed, bound_m=self._bound_m)
        return mown

    def _next(self, cell: Cell) -> list[Cell] | None:
        """Return the path to the next unflown cell: along the lane, else to the side, else the nearest opening.

        Returns None if no such cell is left.
        """
        for di, dj in PRIORITY:
            following = (cell[0] + di, cell[1] + dj)
            if self._open(following):
                return [cell, following]
        return nearest(cell, self._open, self._flown.keys() - self._closed.keys())

    def _open(self, cell: Cell) -> bool:
        """Return whether a cell is within the bound, not flown, and not known to be closed."""
        return (
            cell not in self._flown
            and cell not in self._closed
            and math.dist(self._cells.middle_m(cell), self._start) <= self._bound_m
        )

    def _close(self, cell: Cell, reason: str) -> None:
        if cell not in self._closed:
            self._closed[cell] = reason
            self._vehicle.log("closed", position_m=list(self._cells.middle_m(cell)), reason=reason)

    def _enter(self, cell: Cell, following: Cell) -> Steps[bool]:
        """Fly into a neighbouring cell along the line through both cells; return whether the vehicle got there."""
        edge_m, lookout = self._cells.edge_m, self._lookout
        (x, y), (to_x, to_y) = self._cells.middle_m(cell), self._cells.middle_m(following)
        ahead = ((to_x - x) / edge_m, (to_y - y) / edge_m)
        deadline_s = self._vehicle.time_s + STUCK_S + 4.0 * edge_m / lookout.speed_m_s
        while True:
            at_x, at_y, _ = self._vehicle.pose.position_world_m.tolist()
            left_m = (to_x - at_x) * ahead[0] + (to_y - at_y) * ahead[1]
            aside_m = abs((to_y - at_y) * ahead[0] - (to_x - at_x) * ahead[1])
            if left_m < ARRIVED * edge_m and aside_m < 0.5 * edge_m:
                self._flown[following] = None
                self._stuck = 0
                return True
            if following in self._closed and following not in self._flown:
                return False
            if not math.isfinite(height_above_bed_m(self._vehicle)):
                self._close(following, "no bed below")
                return False
            if self._vehicle.time_s > deadline_s:
                self._close(following, "stuck")
                self._stuck += 1
                if self._stuck == STUCK_CELLS:
                    raise StoppedError(f"stuck at ({at_x:.1f}, {at_y:.1f}) m")
                return False
            reach_m = OVERSHOOT * edge_m
            yield from lookout.towards((to_x + reach_m * ahead[0], to_y + reach_m * ahead[1]))
            self._chart()
            if lookout.must_stop and self._facing(ahead):
                self._close(following, "too high ahead")
                return False

    def _facing(self, ahead: tuple[float, float]) -> bool:
        yaw_rad = self._vehicle.pose.yaw_rad
        return math.cos(yaw_rad) * ahead[0] + math.sin(yaw_rad) * ahead[1] > math.cos(math.radians(30.0))

    def _chart(self) -> None:
        """Close the cells that contain anything the vehicle cannot pass over."""
        echoes = self._lookout.echoes_world_m
        high = echoes[echoes[:, 2] > PASSABLE_Z_M]
        if len(high) < ECHOES_TO_CLOSE:
            return
        cells, counts = np.unique(self._cells.of(high), axis=0, return_counts=True)
        for i, j in cells[counts >= ECHOES_TO_CLOSE].tolist():
            if (i, j) not in self._flown:
                self._close((i, j), "shoal")
