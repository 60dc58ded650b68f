"""Square cells of the horizontal plane: where a vehicle has been, what is closed to it, and the way between."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Cell = tuple[int, int]
NEIGHBOURS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))


class Cells:
    """Numbers cells of edge_m from the first one, about origin_world_m (2,); the first axis is along heading_rad."""

    def __init__(self, origin_world_m: Sequence[float], heading_rad: float, edge_m: float) -> None:
        self._origin = float(origin_world_m[0]), float(origin_world_m[1])
        self._cos, self._sin = math.cos(heading_rad), math.sin(heading_rad)
        self.edge_m = edge_m

    def middle_m(self, cell: Cell) -> tuple[float, float]:
        """The middle of a cell in the world."""
        along, across = cell[0] * self.edge_m, cell[1] * self.edge_m
        x, y = self._origin
        return x + self._cos * along - self._sin * across, y + self._sin * along + self._cos * across

    def of(self, points_world_m: NDArray[np.float64]) -> NDArray[np.int64]:
        """The cells (n, 2) of points (n, 2) or (n, 3)."""
        away = np.asarray(points_world_m, np.float64)[:, :2] - self._origin
        axes = np.array([[self._cos, -self._sin], [self._sin, self._cos]])
        cells: NDArray[np.int64] = np.floor(away @ axes / self.edge_m + 0.5).astype(np.int64)
        return cells

    def cell_of(self, point_world_m: Sequence[float] | NDArray[np.float64]) -> Cell:
        """The cell of one point."""
        i, j = self.of(np.asarray(point_world_m, np.float64)[None])[0].tolist()
        return i, j


def nearest(start: Cell, wanted: Callable[[Cell], bool], passable: Callable[[Cell], bool]) -> list[Cell] | None:
    """The shortest way from a cell to the nearest wanted one over passable cells, both ends included; None if none.

    A wanted cell need not be passable. Of equal ways it is always the same one.
    """
    before: dict[Cell, Cell | None] = {start: None}
    queue = deque([start])
    while queue:
        cell = queue.popleft()
        if cell != start and wanted(cell):
            way = [cell]
            while (previous := before[way[-1]]) is not None:
                way.append(previous)
            return way[::-1]
        if cell != start and not passable(cell):
            continue
        for di, dj in NEIGHBOURS:
            following = (cell[0] + di, cell[1] + dj)
            if following not in before and (wanted(following) or passable(following)):
                before[following] = cell
                queue.append(following)
    return None
