"""A chart of the shoals that the sonar has seen, and the paths around them."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from uwsim import _core
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
