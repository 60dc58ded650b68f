"""A bathymetric grid, computed from the occupied voxels of a map or from a point cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.ranging import CONFIDENCE

MAX_CELLS = 100_000_000


@dataclass(frozen=True, eq=False)
class DepthGrid:
    """Depths below the mean water surface, positive down, in square cells.

    depth_m: (rows, columns), median depth of the points in a cell, nan in empty cells. count: (rows, columns) int64,
    number of points in the cell. uncertainty_m: (rows, columns), of the depth at 95 %, nan where it is unknown; None if
    the points state none. Rows run from south to north, columns from west to east. The cells are cell_m wide,
    with corners at multiples of cell_m. west_m, south_m: the south-west corner of the grid in the world.
    """

    depth_m: NDArray[np.float64]
    count: NDArray[np.int64]
    cell_m: float
    west_m: float
    south_m: float
    uncertainty_m: NDArray[np.float64] | None = None

    @property
    def extent_m(self) -> tuple[float, float, float, float]:
        """The west, east, south and north bounds in the world."""
        rows, columns = self.depth_m.shape
        return (
            self.west_m,
            self.west_m + columns * self.cell_m,
            self.south_m,
            self.south_m + rows * self.cell_m,
        )


def depth_grid(
    points_world_m: NDArray[np.floating], cell_m: float, deviation_m: NDArray[np.floating] | None = None
) -> DepthGrid:
    """Return the median depth and the number of points in each cell, for points (n, 3), n > 0.

    deviation_m (n,): the points' vertical standard deviations, nan where unknown. The uncertainty of a cell is then
    1.96 times the greater of their root mean square and the standard deviation of its points' depths, as the product
    uncertainty of BAGs.

    Raises ValueError unless cell_m is positive, the points are finite and there are at most MAX_CELLS cells.
    """
    points = np.asarray(points_world_m, np.float64)
    if not (np.isfinite(cell_m) and cell_m > 0.0):
        raise ValueError(f"cell_m = {cell_m} m: must be positive")
    if not len(points):
        raise ValueError("points_world_m: no points to grid")
    if not np.isfinite(points).all():
        raise ValueError("points_world_m: must be finite")
    low, high = np.floor(points[:, :2].min(axis=0) / cell_m), np.floor(points[:, :2].max(axis=0) / cell_m)
    cells = float(np.prod(high - low + 1.0))
    if cells > MAX_CELLS:
        raise ValueError(f"cell_m = {cell_m:g} m: gives {cells:.3g} cells, must be at most {MAX_CELLS:.3g}")
    columns, rows = (high - low + 1.0).astype(np.int64)
    at = np.floor(points[:, :2] / cell_m) - low
    cell = (at[:, 1] * columns + at[:, 0]).astype(np.int64)
    depths = -points[:, 2]
    rank = np.empty(len(cell), np.int64)
    rank[np.argsort(depths)] = np.arange(len(cell))
    order = np.argsort(cell * len(cell) + rank)  # the same as np.lexsort((depths, cell)), but much faster
    cell, depths = cell[order], depths[order]
    first = np.flatnonzero(np.diff(cell, prepend=-1))
    filled, count = cell[first], np.diff(first, append=len(cell))
    median, counts = np.full(rows * columns, np.nan), np.zeros(rows * columns, np.int64)
    median[filled] = 0.5 * (depths[first + (count - 1) // 2] + depths[first + count // 2])
    counts[filled] = count
    west, south = low * cell_m
    uncertainty = None
    if deviation_m is not None:
        deviations = np.asarray(deviation_m, np.float64)[order]
        uncertainty = np.full(rows * columns, np.nan)
        uncertainty[filled] = CONFIDENCE * np.fmax(_stated(deviations, first), _spread(depths, first))
        uncertainty = uncertainty.reshape(rows, columns)
    return DepthGrid(
        median.reshape(rows, columns), counts.reshape(rows, columns), cell_m, float(west), float(south), uncertainty
    )


def _stated(deviations: NDArray[np.float64], first: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the root mean square of the known deviations of each cell, whose points begin at `first`."""
    known = np.isfinite(deviations)
    count = np.add.reduceat(known.astype(np.float64), first)
    squares = np.add.reduceat(np.where(known, deviations, 0.0) ** 2, first)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.sqrt(squares / count), np.float64)


def _spread(depths: NDArray[np.float64], first: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the standard deviation of the depths of each cell, nan for a single one."""
    count = np.diff(first, append=len(depths)).astype(np.float64)
    mean = np.add.reduceat(depths, first) / count
    squares = np.add.reduceat((depths - np.repeat(mean, count.astype(int))) ** 2, first)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.sqrt(squares / (count - 1.0)), np.float64)
