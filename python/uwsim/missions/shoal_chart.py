"""Charts of what the sonar has seen: shoals in the way, and the obstacles ahead that decide how high to fly."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.sealed import Sealed
from uwsim.missions.grid_ways import GridWays
from uwsim.navigation.control.protocols import PingLike

Point = tuple[float, float]
Cell = tuple[int, int]

CELL_M = 4.0
ECHOES_IN_A_CELL = 4  # minimum echoes in one ping, since a single echo may be a false detection
# cost of a cell next to a shoal: high, so that such cells are crossed only to leave a shoal
BESIDE_A_SHOAL = 20.0
MARGIN_CELLS = 15  # margin of the search grid around start, goal and shoals
STEPS_TO_LEAVE = 4  # steps of half a cell


class ShoalChart(Sealed):
    """Square cells of the horizontal plane that contain anything higher than top_z_m.

    A vehicle cannot pass over them, and stays at least one cell away from them.
    """

    top_z_m: float
    _fixed_when = "the chart is made"

    def __init__(self, top_z_m: float) -> None:
        self.top_z_m = top_z_m
        self._shoals: set[Cell] = set()
        self._near: set[Cell] = set()
        self._known_way: tuple[Cell, Cell, list[Cell] | None] | None = None  # start, goal, path; for the current chart

    @property
    def cells(self) -> list[Cell]:
        """The (east, north) indices of all shoal cells, sorted."""
        return sorted(self._shoals)

    def add(self, ping: PingLike) -> None:
        """Chart the shoals in a ping."""
        points = _core.points_above(ping.points_sonar_m, ping.world_from_sonar, self.top_z_m)
        if len(points) < ECHOES_IN_A_CELL:
            return
        cells, echoes = np.unique(np.floor(points[:, :2] / CELL_M).astype(np.int64), axis=0, return_counts=True)
        self._chart((int(i), int(j)) for i, j in cells[echoes >= ECHOES_IN_A_CELL])

    def close(self, point_m: Point) -> None:
        """Chart a point's cell as one that the vehicle cannot enter, for a reason other than height."""
        self._chart([_cell(point_m)])

    def blocks(self, start_m: Point, end_m: Point) -> bool:
        """Return whether a shoal lies on, or in a cell next to, the straight line between two points.

        A start next to a shoal does not count as blocked, provided that the line leaves the shoal within two cells.
        """
        if not self._near:
            return False
        (x, y), (to_x, to_y) = start_m, end_m
        steps = max(1, math.ceil(math.dist(start_m, end_m) / (0.5 * CELL_M)))
        leaving = _cell(start_m) in self._near
        for k in range(steps + 1):
            cell = _cell((x + k / steps * (to_x - x), y + k / steps * (to_y - y)))
            leaving = leaving and k <= STEPS_TO_LEAVE and cell not in self._shoals
            if cell in self._near and not leaving:
                return True
        return False

    def next_point(self, start_m: Point, goal_m: Point) -> Point | None:
        """Return the point to head for: the goal, or the last visible point on a path around shoals.

        Returns None if there is no path.
        """
        if not self.blocks(start_m, goal_m):
            return goal_m
        way = self._way(_cell(start_m), _cell(goal_m))
        if way is None:
            return None
        ahead = [((i + 0.5) * CELL_M, (j + 0.5) * CELL_M) for i, j in way[1:]]
        in_sight = [point for point in ahead if not self.blocks(start_m, point)]
        return in_sight[-1] if in_sight else ahead[0] if ahead else goal_m

    def _chart(self, cells: Iterable[Cell]) -> None:
        for i, j in cells:
            if (i, j) not in self._shoals:
                self._shoals.add((i, j))
                self._near.update((i + di, j + dj) for di in (-1, 0, 1) for dj in (-1, 0, 1))
                self._known_way = None

    def _way(self, start: Cell, goal: Cell) -> list[Cell] | None:
        """Return the cheapest path over cells that are not shoals, including both ends.

        The result depends only on the chart.
        """
        if self._known_way is None or self._known_way[:2] != (start, goal):
            self._known_way = start, goal, self._search(start, goal)
        return self._known_way[2]

    def _search(self, start: Cell, goal: Cell) -> list[Cell] | None:
        corners = np.array([start, goal, *self._shoals])
        low = corners.min(axis=0) - MARGIN_CELLS
        cost = np.ones(tuple((corners.max(axis=0) + MARGIN_CELLS + 1 - low).tolist()))
        for cells, each in ((self._near, BESIDE_A_SHOAL), (self._shoals, np.inf)):
            at = np.array(sorted(cells)) - low
            cost[at[:, 0], at[:, 1]] = each
        first, last = start - low, goal - low
        cost[tuple(first)] = 1.0
        way = GridWays(cost, first[None]).to(last)
        return None if way is None else [(i, j) for i, j in (way + low).tolist()]


def _cell(point_m: Iterable[float]) -> Cell:
    east_m, north_m = point_m
    return math.floor(east_m / CELL_M), math.floor(north_m / CELL_M)


WORLD = np.eye(4)  # the pose of points that are already in world coordinates


class ObstacleMemory(Sealed):
    """Stores each ping's highest echo in the corridor ahead of the vehicle.

    The corridor extends from half_width_m behind the vehicle to ahead_m in front of it, and half_width_m to either
    side. pings: capacity; once it is full, each new echo overwrites the oldest.
    """

    half_width_m: float
    ahead_m: float
    _fixed_when = "the memory is made"

    def __init__(self, half_width_m: float = 3.0, ahead_m: float = 20.0, pings: int = 300) -> None:
        self.half_width_m = half_width_m
        self.ahead_m = ahead_m
        self._ring = np.empty((pings, 3))
        self._seen = 0

    def __repr__(self) -> str:
        return f"<ObstacleMemory of {min(self._seen, len(self._ring))} peaks, {self.ahead_m:g} m ahead>"

    def add(self, ping: PingLike, position_world_m: Floats, heading_rad: float) -> None:
        """Store a ping's highest echo in the corridor, if any."""
        peak = self._highest(ping.points_sonar_m, ping.world_from_sonar, position_world_m, heading_rad)
        if peak is not None:
            self._ring[self._seen % len(self._ring)] = peak
            self._seen += 1

    def highest_m(self, position_world_m: Floats, heading_rad: float) -> float:
        """Return the height (z) of the highest stored echo in the corridor, or -inf if there is none."""
        peaks = self._ring[: min(self._seen, len(self._ring))]
        peak = self._highest(peaks, WORLD, position_world_m, heading_rad)
        return -math.inf if peak is None else peak[2]

    def _highest(
        self, points_m: NDArray[Any], world_from_points: NDArray[Any], position_world_m: Floats, heading_rad: float
    ) -> tuple[float, float, float] | None:
        """Return the highest of the points (n, 3) in the corridor; NaN points are ignored."""
        return _core.highest_in_corridor(
            points_m, world_from_points, position_world_m, heading_rad, self.half_width_m, self.ahead_m
        )
