"""Square cells in the horizontal plane, and the shortest path over them to the nearest cell of interest."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.missions.grid_ways import GridWays

Cell = tuple[int, int]
NEIGHBOURS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))


class Cells:
    """A grid of square cells with edge length edge_m; cell (0, 0) is centred on origin_world_m (2,).

    The first axis is along heading_rad.
    """

    def __init__(self, origin_world_m: Sequence[float], heading_rad: float, edge_m: float) -> None:
        self._origin = float(origin_world_m[0]), float(origin_world_m[1])
        self._cos, self._sin = math.cos(heading_rad), math.sin(heading_rad)
        self.edge_m = edge_m

    def middle_m(self, cell: Cell) -> tuple[float, float]:
        """Return the world position of a cell's centre."""
        along, across = cell[0] * self.edge_m, cell[1] * self.edge_m
        x, y = self._origin
        return x + self._cos * along - self._sin * across, y + self._sin * along + self._cos * across

    def of(self, points_world_m: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the cells (n, 2) of points (n, 2) or (n, 3)."""
        away = np.asarray(points_world_m, np.float64)[:, :2] - self._origin
        axes = np.array([[self._cos, -self._sin], [self._sin, self._cos]])
        cells: NDArray[np.int64] = np.floor(away @ axes / self.edge_m + 0.5).astype(np.int64)
        return cells

    def cell_of(self, point_world_m: Sequence[float] | NDArray[np.float64]) -> Cell:
        """Return the cell of one point."""
        i, j = self.of(np.asarray(point_world_m, np.float64)[None])[0].tolist()
        return i, j


def nearest(start: Cell, wanted: Callable[[Cell], bool], passable: Collection[Cell]) -> list[Cell] | None:
    """Return the shortest path from a cell to the nearest wanted one over passable cells, including both ends.

    Returns None if there is no path. A wanted cell need not be passable. Ties between shortest paths are broken in
    favour of the one that keeps to the first direction in NEIGHBOURS for longest, then to the second, and so on.
    """
    ground = {start, *passable}
    goals = {cell for here in ground for cell in _around(here) if cell != start and wanted(cell)}
    if not goals:
        return None
    cells = np.array([*ground, *goals])
    low = cells.min(axis=0) - 1  # a margin of one cell, so that all neighbours of a cell are in the grid
    cost = np.full(tuple((cells.max(axis=0) - low + 2).tolist()), np.inf)
    cost[tuple((cells - low).T)] = 1.0
    steps_left = GridWays(cost, np.array(sorted(goals)) - low, diagonal=False).costs

    def left(cell: Cell) -> float:
        return float(steps_left[tuple(np.subtract(cell, low))])

    if not math.isfinite(left(start)):
        return None
    way = [start]
    while left(way[-1]) > 0.0:
        way.append(next(cell for cell in _around(way[-1]) if left(cell) < left(way[-1])))
    return way


def _around(cell: Cell) -> list[Cell]:
    return [(cell[0] + di, cell[1] + dj) for di, dj in NEIGHBOURS]
