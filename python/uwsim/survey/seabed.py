"""The seabed as a grid of depths, made from a map's voxels or a cloud, and how far it is from the true one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.survey.s44 import Order, best_order
from uwsim.survey.true_surface import TERRAIN_LABEL, inside_polygon

MAX_CELLS = 100_000_000
SAMPLE_SPACING_M = 0.1
SAMPLES_AT_ONCE = 1 << 20
ABOVE_ALL_M = 1.0


@dataclass(frozen=True, eq=False)
class SeabedGrid:
    """Depths below the mean water surface, positive down, cell by cell.

    depth_m: (rows, columns) median of the points in a cell, nan where there are none. count: (rows, columns) int64,
    points in it. Rows run from south to north, columns from west to east; cells are squares of cell_m whose corners are
    at multiples of it. west_m, south_m: the grid's outer corner, world.
    """

    depth_m: NDArray[np.float64]
    count: NDArray[np.int64]
    cell_m: float
    west_m: float
    south_m: float

    @property
    def extent_m(self) -> tuple[float, float, float, float]:
        """West, east, south and north borders, world."""
        rows, columns = self.depth_m.shape
        return (
            self.west_m,
            self.west_m + columns * self.cell_m,
            self.south_m,
            self.south_m + rows * self.cell_m,
        )


@dataclass(frozen=True, eq=False)
class SeabedError:
    """A grid against the terrain.

    error_m: (rows, columns), depth in the grid less true depth, positive where the grid is too deep; nan where the cell
    is not judged: it is empty, off the terrain, outside the polygon or under an obstacle. true_depth_m: (rows,
    columns), mean over the cell. obstructed: (rows, columns) bool, cells with data over which an obstacle stands.
    """

    grid: SeabedGrid
    error_m: NDArray[np.float64]
    true_depth_m: NDArray[np.float64]
    obstructed: NDArray[np.bool_]

    @property
    def judged(self) -> NDArray[np.bool_]:
        """(rows, columns) bool: cells whose error is known."""
        return np.isfinite(self.error_m)

    @property
    def errors_m(self) -> NDArray[np.float64]:
        """(n,) of the judged cells."""
        return self.error_m[self.judged]

    @property
    def depths_m(self) -> NDArray[np.float64]:
        """(n,) true depths of the judged cells."""
        return self.true_depth_m[self.judged]

    @property
    def mean_m(self) -> float:
        """Mean error: a bias. nan when no cell was judged."""
        return float(self.errors_m.mean()) if self.judged.any() else float("nan")

    @property
    def p95_m(self) -> float:
        """The absolute error that 95 % of the cells keep to; nan when no cell was judged."""
        return float(np.percentile(np.abs(self.errors_m), 95.0)) if self.judged.any() else float("nan")

    @property
    def best_order(self) -> Order | None:
        """The strictest order of IHO S-44 whose vertical uncertainty holds for 95 % of the cells."""
        return best_order(self.errors_m, self.depths_m)


def seabed_grid(points_world_m: NDArray[np.floating], cell_m: float) -> SeabedGrid:
    """Grid points (n, 3), n > 0: the median depth and the number of points of each cell.

    Raises ValueError unless cell_m is positive, the points are finite and there are at most MAX_CELLS cells.
    """
    points = np.asarray(points_world_m, np.float64)
    if not (np.isfinite(cell_m) and cell_m > 0.0):
        raise ValueError(f"cell_m = {cell_m} m: must be positive")
    if not len(points):
        raise ValueError("points_world_m: no points to make a grid of")
    if not np.isfinite(points).all():
        raise ValueError("points_world_m: must be finite")
    low, high = np.floor(points[:, :2].min(axis=0) / cell_m), np.floor(points[:, :2].max(axis=0) / cell_m)
    cells = float(np.prod(high - low + 1.0))
    if cells > MAX_CELLS:
        raise ValueError(f"cell_m = {cell_m:g} m: makes {cells:.3g} cells, must be at most {MAX_CELLS:.3g}")
    columns, rows = (high - low + 1.0).astype(np.int64)
    at = np.floor(points[:, :2] / cell_m) - low
    cell = (at[:, 1] * columns + at[:, 0]).astype(np.int64)
    depths = -points[:, 2]
    order = np.lexsort((depths, cell))
    cell, depths = cell[order], depths[order]
    filled, first, count = np.unique(cell, return_index=True, return_counts=True)
    median, counts = np.full(rows * columns, np.nan), np.zeros(rows * columns, np.int64)
    median[filled] = 0.5 * (depths[first + (count - 1) // 2] + depths[first + count // 2])
    counts[filled] = count
    west, south = low * cell_m
    return SeabedGrid(median.reshape(rows, columns), counts.reshape(rows, columns), cell_m, float(west), float(south))


def seabed_error(
    world: _core.World, rays: _core.RayScene, grid: SeabedGrid, area_world_m: NDArray[np.float64]
) -> SeabedError:
    """Compare the cells whose centres lie in the polygon (k, 2) with the mean height of the terrain over each.

    The terrain is read off, and looked for obstacles over it, every 0.1 m or closer, the cell's edges included.
    """
    rows, columns = np.nonzero(grid.count)
    centres = np.stack([grid.west_m + (columns + 0.5) * grid.cell_m, grid.south_m + (rows + 0.5) * grid.cell_m], axis=1)
    inside = inside_polygon(centres, area_world_m)
    rows, columns, centres = rows[inside], columns[inside], centres[inside]
    height, blocked = _terrain_over(world, rays, centres, grid.cell_m)
    error, true_depth = np.full(grid.depth_m.shape, np.nan), np.full(grid.depth_m.shape, np.nan)
    obstructed = np.zeros(grid.depth_m.shape, bool)
    true_depth[rows, columns] = -height
    obstructed[rows, columns] = blocked
    error[rows, columns] = np.where(blocked, np.nan, grid.depth_m[rows, columns] + height)
    return SeabedError(grid, error, true_depth, obstructed)


def _terrain_over(
    world: _core.World, rays: _core.RayScene, centres_m: NDArray[np.float64], cell_m: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the mean height of the terrain over each cell (n,), nan off it, and whether an obstacle stands there."""
    vertices, _, labels = world.surface_mesh()
    top_m = float(vertices[:, 2].max(initial=0.0)) + ABOVE_ALL_M
    reach_m = top_m - float(vertices[:, 2].min(initial=0.0)) + ABOVE_ALL_M
    has_solids = bool((labels != TERRAIN_LABEL).any())
    steps = int(np.ceil(cell_m / SAMPLE_SPACING_M - 1e-9)) + 1
    offset = (np.linspace(-0.5, 0.5, steps)) * cell_m
    offsets = np.stack(np.meshgrid(offset, offset), axis=-1).reshape(-1, 2)
    height, blocked = np.empty(len(centres_m)), np.zeros(len(centres_m), bool)
    cells_at_once = max(SAMPLES_AT_ONCE // len(offsets), 1)
    for start in range(0, len(centres_m), cells_at_once):
        some = slice(start, start + cells_at_once)
        xy = (centres_m[some, None] + offsets).reshape(-1, 2)
        height[some] = world.height_at(xy).reshape(-1, len(offsets)).mean(axis=1)
        if has_solids:
            origins = np.column_stack([xy, np.full(len(xy), top_m)])
            down = np.broadcast_to(np.array([0.0, 0.0, -1.0]), origins.shape).copy()
            first = rays.cast(origins, down, reach_m)
            other = np.isfinite(first.ranges_m) & (first.labels != TERRAIN_LABEL)
            blocked[some] = other.reshape(-1, len(offsets)).any(axis=1)
    return height, blocked
