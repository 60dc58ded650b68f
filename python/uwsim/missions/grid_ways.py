"""Paths over a grid of square or cubic cells: the grid's geometry, and the cheapest paths between cells."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Cells = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Grid:
    """A grid of cells with edge length edge_m in any number of dimensions d; its lower corner is low_m (d,)."""

    low_m: Floats
    edge_m: float
    shape: tuple[int, ...]

    def cells_of(self, points_m: Floats) -> Cells:
        """Return the cells (n, d) that contain the points (n, d), which may lie outside the grid."""
        cells: Cells = np.floor((points_m - self.low_m) / self.edge_m).astype(np.int64)
        return cells

    def holds(self, cells: Cells) -> NDArray[np.bool_]:
        """Return a mask (n,) of the cells (n, d) that are inside the grid."""
        return np.asarray(((cells >= 0) & (cells < self.shape)).all(axis=1))

    def centres(self, cells: NDArray[Any]) -> Floats:
        """Return the centres (n, d) of cells (n, d)."""
        return np.asarray(self.low_m + (cells + 0.5) * self.edge_m, np.float64)

    def all_centres(self) -> Floats:
        """Return the centres (n, d) of all cells; the last axis varies fastest."""
        return self.centres(np.indices(self.shape).reshape(len(self.shape), -1).T)

    def line(self, start_m: Floats, end_m: Floats) -> Cells:
        """Return the cells (n, d) along a straight line, sampled at most half an edge apart, including both ends."""
        count = max(2, math.ceil(2.0 * float(np.linalg.norm(end_m - start_m)) / self.edge_m) + 1)
        return self.cells_of(start_m + np.linspace(0.0, 1.0, count)[:, None] * (end_m - start_m))


class GridWays:
    """The cheapest path to each cell of a grid from the nearest of several source cells, by Dijkstra's algorithm.

    cost: cost of each cell, one axis per dimension; inf makes a cell impassable. A step to a neighbour costs its length
    in cells times the mean cost of the two cells. sources: cells (n, d). diagonal: whether cells that touch only at an
    edge or a corner are also neighbours.
    """

    def __init__(self, cost: Floats, sources: Cells, *, diagonal: bool = True) -> None:
        from scipy.sparse.csgraph import dijkstra  # imported here because it is slow to import and few missions need it

        costs, self._before, _ = dijkstra(
            _graph(cost, diagonal),
            directed=False,
            indices=np.ravel_multi_index(tuple(sources.T), cost.shape),
            return_predecessors=True,
            min_only=True,
        )
        self.costs: Floats = costs.reshape(cost.shape)
        """The cost of the path to each cell; inf if there is no path."""

    def to(self, cell: Cells) -> Cells | None:
        """Return the cells (n, d) of the path to a cell (d,), including both ends, or None if there is no path."""
        if not math.isfinite(self.costs[tuple(cell)]):
            return None
        way = [int(np.ravel_multi_index(tuple(cell), self.costs.shape))]
        while (before := int(self._before[way[-1]])) >= 0:
            way.append(before)
        return np.array(np.unravel_index(way[::-1], self.costs.shape)).T


def straightened(points: Floats, clear: Callable[[Floats, Floats], bool]) -> Floats:
    """Drop points from a path (n, d) wherever the straight line that bypasses them is clear."""
    kept, k = [points[0]], 0
    while k < len(points) - 1:
        k = next((j for j in range(len(points) - 1, k + 1, -1) if clear(points[k], points[j])), k + 1)
        kept.append(points[k])
    return np.array(kept)


def _graph(cost: Floats, diagonal: bool) -> csr_array:
    """Return the graph of cells, in which each cell has edges only to the neighbours that come after it."""
    from scipy.sparse import coo_array

    number = np.arange(cost.size).reshape(cost.shape)
    rows, columns, weights = [], [], []
    for step in product((-1, 0, 1), repeat=cost.ndim):
        if step <= (0,) * cost.ndim or not (diagonal or sum(map(abs, step)) == 1):
            continue
        here = tuple(slice(max(0, -d), -d if d > 0 else None) for d in step)
        there = tuple(slice(max(0, d), d if d < 0 else None) for d in step)
        weight = math.hypot(*step) * 0.5 * (cost[here] + cost[there])
        passable = np.isfinite(weight)
        rows.append(number[here][passable])
        columns.append(number[there][passable])
        weights.append(weight[passable])
    edges = np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))
    return coo_array(edges, shape=(cost.size, cost.size)).tocsr()
