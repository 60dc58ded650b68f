"""A digital twin: map an area while mowing it, revisit places where the map is thin or uncertain, return and dock.

A column of the map is thin if no voxel in it is occupied. It is uncertain if no voxel in it is occupied with a
probability of at least `certain`, either because observations contradict each other or because only one or two were
made, from afar.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping import OccupancyMap
from uwsim.missions.lanes import Lane
from uwsim.missions.moves import goto, hold
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.area_chart import AreaChart
from uwsim.missions.planners.boustrophedon import boustrophedon_lanes, checked_area
from uwsim.missions.planners.cells import Cell, Cells
from uwsim.missions.planners.lane_flight import fly_lanes
from uwsim.missions.planners.live_map import LiveMap
from uwsim.missions.planners.unknown_water import find_bed
from uwsim.missions.planners.wayfinder import PASSABLE_Z_M, Wayfinder
from uwsim.missions.steps import Steps, StoppedError
from uwsim.navigation.control.protocols import PingLike, PoseLike

PING_PERIOD_S = 0.2
PATCH = 3  # number of columns along each side of the patches that are revisited
DOCK_AHEAD_M, DOCK_SPEED_M_S, SETTLE_S = 0.8, 0.2, 3.0


@dataclass(frozen=True, eq=False)
class Twin:
    """The outcome of `make_twin`. map: built during the whole flight; first_map: the map before any revisit.

    weak_before, weak_after: fraction of the area's columns that were thin or uncertain, before and after. patches:
    number of patches revisited. docked: whether the vehicle is back in the station's dock.
    """

    map: OccupancyMap
    first_map: OccupancyMap
    weak_before: float
    weak_after: float
    patches: int
    docked: bool


def make_twin(
    vehicle: OwnVehicle,
    area_m: Sequence[Sequence[float]],
    *,
    altitude_m: float = 3.0,
    speed_m_s: float = 0.6,
    overlap: float = 0.2,
    resolution_m: float = 0.25,
    certain: float = 0.8,
    most_patches: int = 20,
) -> Steps[Twin]:
    """Build the twin of an area (k, 2); a docked vehicle first undocks, and docks again at the end.

    Logs `weak` with the fraction of weak columns after each stage, `patch` for each revisited patch, and `docked`.
    Raises ValueError for invalid arguments, StoppedError if the vehicle cannot continue.
    """
    if not 0.5 < certain < 1.0:
        raise ValueError(f"certain = {certain}: must be above 0.5 and below 1")
    dock = None if vehicle.released else vehicle.pose
    if dock is not None:
        vehicle.undock()
    away = np.array(vehicle.pose.position_world_m, np.float64)
    cells = Cells((float(away[0]), float(away[1])), 0.0, 2.0 * resolution_m)
    live = LiveMap(vehicle, resolution_m, cells, PING_PERIOD_S)
    chart = AreaChart(checked_area(area_m), PASSABLE_Z_M, np.array(away[:2]))

    def on_ping(ping: PingLike, echoes_world_m: NDArray[np.float64]) -> None:
        live.add(ping, echoes_world_m)
        chart.add(echoes_world_m)

    lookout = Wayfinder(vehicle, altitude_m, speed_m_s, on_ping=on_ping)
    lanes = boustrophedon_lanes(area_m, (1.0 - overlap) * lookout.swath_m, np.asarray(away[:2], np.float64))
    inside = _columns(cells, boustrophedon_lanes(area_m, cells.edge_m, np.asarray(away[:2], np.float64)))
    yield from lookout.tilt()
    yield from find_bed(vehicle)
    yield from fly_lanes(lookout, lanes, chart)
    first_map = OccupancyMap(resolution_m=resolution_m)
    first_map.merge(live.map)

    def weak() -> set[Cell]:
        certainty = live.certainty()
        return {cell for cell in inside if certainty.get(cell, 0.0) < certain}

    now = before = weak()
    vehicle.log("weak", share=len(before) / len(inside), stage="mown")
    tried: set[Cell] = set()
    while len(tried) < most_patches and (patch := _worst(now, tried, cells, vehicle)) is not None:
        tried.add(patch)
        vehicle.log("patch", position_m=list(_middle(patch, cells)))
        yield from lookout.go_to(_middle(patch, cells))
        now = weak()
    vehicle.log("weak", share=len(now) / len(inside), stage="flown again")
    if dock is not None:
        yield from return_and_dock(lookout, dock, away)
    return Twin(live.map, first_map, len(before) / len(inside), len(now) / len(inside), len(tried), dock is not None)


def return_and_dock(lookout: Wayfinder, dock: PoseLike, exit_world_m: NDArray[np.float64]) -> Steps[None]:
    """Return to the dock's exit, enter the dock, and dock. Raises StoppedError if there is no path back."""
    vehicle = lookout.vehicle
    if not (yield from lookout.go_to(exit_world_m[:2])):
        raise StoppedError("no path led back to the station")
    yaw_rad = dock.yaw_rad
    ahead = np.array([math.cos(yaw_rad), math.sin(yaw_rad), 0.0])
    yield from goto(vehicle, exit_world_m, heading_rad=yaw_rad, within_m=0.3)
    entry = np.asarray(dock.position_world_m) + DOCK_AHEAD_M * ahead
    yield from goto(vehicle, entry, heading_rad=yaw_rad, speed_m_s=DOCK_SPEED_M_S, within_m=0.3)
    yield from hold(vehicle, SETTLE_S, position_world_m=entry, heading_rad=yaw_rad)
    vehicle.dock()
    vehicle.log("docked")


def _columns(cells: Cells, lanes: Sequence[Lane]) -> set[Cell]:
    """Return the columns inside the polygon, found along lanes that are one column apart."""
    points = []
    for lane in lanes:
        steps = np.arange(0.0, lane.length_m, 0.5 * cells.edge_m)
        points.append(lane.start_m + steps[:, None] * lane.direction)
    return {(i, j) for i, j in cells.of(np.concatenate(points)).tolist()}


def _worst(weak: set[Cell], tried: set[Cell], cells: Cells, vehicle: OwnVehicle) -> Cell | None:
    """Return the nearest untried patch in which at least half of the columns are weak."""
    counts: dict[Cell, int] = {}
    for i, j in sorted(weak):
        patch = (i // PATCH, j // PATCH)
        counts[patch] = counts.get(patch, 0) + 1
    candidates = [p for p, count in counts.items() if p not in tried and 2 * count >= PATCH**2]
    x, y, _ = vehicle.pose.position_world_m.tolist()
    return min(candidates, key=lambda p: math.dist(_middle(p, cells), (x, y)), default=None)


def _middle(patch: Cell, cells: Cells) -> tuple[float, float]:
    """Return the world position of a patch's centre."""
    corners = [
        cells.middle_m((PATCH * patch[0] + a, PATCH * patch[1] + b)) for a, b in product((0, PATCH - 1), repeat=2)
    ]
    x, y = np.mean(corners, axis=0).tolist()
    return x, y
