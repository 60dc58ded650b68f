"""A way through an OctoMap: shortest over voxels that are known to be free and far enough from all that are not.

Unknown water is taken for an obstacle. The clearance of each voxel is its distance from the nearest one that is not
free (an exact Euclidean distance transform); the way is Dijkstra's over the 26 neighbours of voxels with enough of it,
drawn straight afterwards wherever a straight line keeps the clearance, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from uwsim.mapping import OccupancyMap
from uwsim.missions.moves import goto
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.steps import Steps
from uwsim.missions.stopped import StoppedError

Floats = NDArray[np.float64]
MOST_VOXELS = 4_000_000
HALF_OF_26 = [step for step in product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]


class FreeWater:
    """The free water of a map in a box, and the ways through it. low_world_m, high_world_m: its corners (3,).

    clearance_m: that ways keep from everything that is not known to be free. Raises ValueError.
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
        self._edge_m, self._corner = edge_m, origin + first * edge_m
        centres = self._corner + (np.indices(tuple(shape)).reshape(3, -1).T + 0.5) * edge_m
        free = (occupancy.state_at(centres) == 0).reshape(tuple(shape))
        walled = np.pad(free, 1)  # what lies outside the box is not known
        clear_m = edge_m * (distance_transform_edt(walled)[1:-1, 1:-1, 1:-1] - 0.5)
        self._open = free & (clear_m >= clearance_m)

    def way(self, start_world_m: Sequence[float] | Floats, goal_world_m: Sequence[float] | Floats) -> Floats | None:
        """The corners of the way from start to goal, (n, 3), both included; None if there is none.

        A start or goal that is too near to something is reached over the nearest open voxel.
        """
        start, goal = np.asarray(start_world_m, np.float64), np.asarray(goal_world_m, np.float64)
        if not self._open.any():
            return None
        first, last = self._nearest_open(start), self._nearest_open(goal)
        voxels = self._search(first, last)
        if voxels is None:
            return None
        places = self._corner + (voxels + 0.5) * self._edge_m
        ends = [start] if self._near(start, places[0]) else [start, places[0]]
        ends_there = [goal] if self._near(goal, places[-1]) else [places[-1], goal]
        inner = self._straightened(np.vstack([ends[-1:], places[1:-1], ends_there[:1]]))
        return np.vstack([*ends[:-1], inner, *ends_there[1:]])

    def _near(self, point: Floats, centre: Floats) -> bool:
        """Whether a point lies in the voxel about a centre."""
        return bool((np.abs(point - centre) < 0.5 * self._edge_m).all())

    def _nearest_open(self, point: Floats) -> int:
        """The number of the open voxel that is nearest to a point."""
        voxels = np.argwhere(self._open)
        away = np.linalg.norm(self._corner + (voxels + 0.5) * self._edge_m - point, axis=1)
        return int(np.ravel_multi_index(tuple(voxels[int(np.argmin(away))]), self._open.shape))

    def _search(self, first: int, last: int) -> NDArray[np.int64] | None:
        distance, before = dijkstra(self._graph(), directed=False, indices=first, return_predecessors=True)
        if not math.isfinite(distance[last]):
            return None
        way = [last]
        while way[-1] != first:
            way.append(int(before[way[-1]]))
        return np.array(np.unravel_index(way[::-1], self._open.shape)).T

    def _graph(self) -> coo_array:
        number = np.arange(self._open.size).reshape(self._open.shape)
        rows, columns, lengths = [], [], []
        for step in HALF_OF_26:
            here = tuple(slice(max(0, -d), -d if d > 0 else None) for d in step)
            there = tuple(slice(max(0, d), d if d < 0 else None) for d in step)
            both = self._open[here] & self._open[there]
            rows.append(number[here][both])
            columns.append(number[there][both])
            lengths.append(np.full(len(rows[-1]), math.hypot(*step)))
        edges = np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))
        return coo_array(edges, shape=(self._open.size, self._open.size)).tocsr()

    def _straightened(self, points: Floats) -> Floats:
        """Leave out the points between which a straight line keeps the clearance."""
        kept, k = [points[0]], 0
        while k < len(points) - 1:
            ahead = next((j for j in range(len(points) - 1, k + 1, -1) if self._clear(points[k], points[j])), k + 1)
            kept.append(points[ahead])
            k = ahead
        return np.array(kept)

    def _clear(self, a: Floats, b: Floats) -> bool:
        count = max(2, math.ceil(2.0 * float(np.linalg.norm(b - a)) / self._edge_m) + 1)
        places = a + np.linspace(0.0, 1.0, count)[:, None] * (b - a)
        i, j, k = np.floor((places - self._corner) / self._edge_m).astype(np.int64).T
        return bool(self._open[i, j, k].all())


def go_by_map(
    vehicle: OwnVehicle,
    occupancy: OccupancyMap,
    goal_world_m: Sequence[float] | Floats,
    *,
    clearance_m: float = 1.0,
    margin_m: float = 15.0,
    speed_m_s: float = 0.4,
) -> Steps[Floats]:
    """Go to a position (3,) through water that a map knows to be free; return the way's corners (n, 3).

    margin_m: how far around start and goal the way may lead. Raises StoppedError if there is no way.
    """
    goal = np.asarray(goal_world_m, np.float64)
    start = np.array(vehicle.pose.position_world_m, np.float64)
    low, high = np.minimum(start, goal) - margin_m, np.maximum(start, goal) + margin_m
    high[2] = min(high[2], 0.0)
    way = FreeWater(occupancy, low.tolist(), high.tolist(), clearance_m).way(start, goal)
    if way is None:
        x, y, z = goal.tolist()
        raise StoppedError(f"the map knows no free way to ({x:.1f}, {y:.1f}, {z:.1f}) m")
    vehicle.log("way", corners=len(way), length_m=float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()))
    for corner in way[1:]:
        yield from goto(vehicle, corner, speed_m_s=speed_m_s, within_m=0.4)
    return way
