"""Paths through an OctoMap: the shortest over voxels known to be free and far enough from all other voxels.

Unknown water counts as an obstacle. The clearance of a voxel is its distance from the nearest voxel that is not free
(an exact Euclidean distance transform). Paths are found with Dijkstra's algorithm over the 26 neighbours of voxels with
enough clearance, and straightened wherever a straight line maintains the clearance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from uwsim.base.arrays import Floats
from uwsim.mapping import OccupancyMap
from uwsim.missions.grid_ways import Grid, GridWays, straightened
from uwsim.missions.moves import goto
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.steps import Steps, StoppedError

MOST_VOXELS = 4_000_000


class FreeWater:
    """The free water of a map within a box, and the paths through it.

    low_world_m, high_world_m: corners of the box, (3,). clearance_m: distance that paths keep from everything that is
    not known to be free. Raises ValueError for a negative clearance, or for a box that is empty or too large.
    """

    def __init__(
        self, occupancy: OccupancyMap, low_world_m: Sequence[float], high_world_m: Sequence[float], clearance_m: float
    ) -> None:
        if not 0.0 <= clearance_m < math.inf:
            raise ValueError(f"clearance_m = {clearance_m} m: must not be negative")
        edge_m, origin = occupancy.resolution_m, occupancy.origin_world_m
        first = np.floor((np.asarray(low_world_m, np.float64) - origin) / edge_m).astype(np.int64)
        last = np.floor((np.asarray(high_world_m, np.float64) - origin) / edge_m).astype(np.int64)
        shape = last - first + 1
        if (shape < 1).any() or int(np.prod(shape)) > MOST_VOXELS:
            rule = f"must be a box of at most {MOST_VOXELS:,} voxels of {edge_m:g} m"
            raise ValueError(f"low_world_m = {list(low_world_m)}, high_world_m = {list(high_world_m)} m: {rule}")
        self._grid = Grid(origin + first * edge_m, edge_m, tuple(shape.tolist()))
        free = (occupancy.state_at(self._grid.all_centres()) == 0).reshape(self._grid.shape)
        walled = np.pad(free, 1)  # everything outside the box is unknown
        clear_m = edge_m * (distance_transform_edt(walled)[1:-1, 1:-1, 1:-1] - 0.5)
        self._open = free & (clear_m >= clearance_m)

    def way(self, start_world_m: Sequence[float] | Floats, goal_world_m: Sequence[float] | Floats) -> Floats | None:
        """Return the waypoints of a path from start to goal, (n, 3), including both, or None if there is no path.

        A start or goal too close to an obstacle is reached through the nearest open voxel.
        """
        start, goal = np.asarray(start_world_m, np.float64), np.asarray(goal_world_m, np.float64)
        if not self._open.any():
            return None
        first, last = self._nearest_open(start), self._nearest_open(goal)
        voxels = GridWays(np.where(self._open, 1.0, np.inf), first[None]).to(last)
        if voxels is None:
            return None
        places = self._grid.centres(voxels)
        ends = [start] if self._near(start, places[0]) else [start, places[0]]
        ends_there = [goal] if self._near(goal, places[-1]) else [places[-1], goal]
        inner = straightened(np.vstack([ends[-1:], places[1:-1], ends_there[:1]]), self._clear)
        return np.vstack([*ends[:-1], inner, *ends_there[1:]])

    def _near(self, point: Floats, centre: Floats) -> bool:
        """Return whether a point lies in the voxel centred at `centre`."""
        return bool((np.abs(point - centre) < 0.5 * self._grid.edge_m).all())

    def _nearest_open(self, point: Floats) -> NDArray[np.int64]:
        """Return the open voxel (3,) nearest to a point."""
        voxels = np.argwhere(self._open)
        away = np.linalg.norm(self._grid.centres(voxels) - point, axis=1)
        return np.asarray(voxels[int(np.argmin(away))])

    def _clear(self, a: Floats, b: Floats) -> bool:
        """Return whether a straight line maintains the clearance."""
        return bool(self._open[tuple(self._grid.line(a, b).T)].all())


def go_by_map(
    vehicle: OwnVehicle,
    occupancy: OccupancyMap,
    goal_world_m: Sequence[float] | Floats,
    *,
    clearance_m: float = 1.0,
    margin_m: float = 15.0,
    speed_m_s: float = 0.4,
) -> Steps[Floats]:
    """Travel to a position (3,) through water that is free in a map; return the path's waypoints (n, 3).

    margin_m: how far the path may extend beyond the box around start and goal. Raises StoppedError if there is no path.
    """
    goal = np.asarray(goal_world_m, np.float64)
    start = np.array(vehicle.pose.position_world_m, np.float64)
    low, high = np.minimum(start, goal) - margin_m, np.maximum(start, goal) + margin_m
    high[2] = min(high[2], 0.0)
    way = FreeWater(occupancy, low.tolist(), high.tolist(), clearance_m).way(start, goal)
    if way is None:
        x, y, z = goal.tolist()
        raise StoppedError(f"the map has no free path to ({x:.1f}, {y:.1f}, {z:.1f}) m")
    vehicle.log("way", corners=len(way), length_m=float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()))
    for corner in way[1:-1]:
        yield from goto(vehicle, corner, speed_m_s=speed_m_s, within_m=0.4)
    yield from goto(vehicle, way[-1], speed_m_s=speed_m_s)
    return way
