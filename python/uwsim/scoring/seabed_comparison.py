"""Compares a depth grid with the true seabed, cell by cell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.polygon import inside
from uwsim.mapping.depth_grid import DepthGrid
from uwsim.scoring.s44 import Order, best_order
from uwsim.scoring.true_surface import TERRAIN_LABEL

SAMPLE_SPACING_M = 0.1
SAMPLES_AT_ONCE = 1 << 20
MARGIN_M = 1.0  # rays start this far above the world's highest point and end this far below its lowest


@dataclass(frozen=True, eq=False)
class SeabedComparison:
    """A depth grid compared with the true terrain.

    error_m: (rows, columns), depth in the grid minus true depth, positive where the grid is too deep; NaN for cells
    that are not scored: empty, off the terrain, outside the polygon or under an obstacle. true_depth_m: (rows,
    columns), mean over the cell. obstructed: (rows, columns) bool, cells with data under an obstacle.
    """

    grid: DepthGrid
    error_m: NDArray[np.float64]
    true_depth_m: NDArray[np.float64]
    obstructed: NDArray[np.bool_]

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Cells with a known error, (rows, columns) bool."""
        return np.isfinite(self.error_m)

    @property
    def errors_m(self) -> NDArray[np.float64]:
        """Errors of the scored cells, (n,)."""
        return self.error_m[self.judged]

    @property
    def depths_m(self) -> NDArray[np.float64]:
        """True depths of the scored cells, (n,)."""
        return self.true_depth_m[self.judged]

    @property
    def mean_m(self) -> float:
        """Mean error (bias), or NaN if no cell was scored."""
        return float(self.errors_m.mean()) if self.judged.any() else float("nan")

    @property
    def p95_m(self) -> float:
        """95th percentile of the absolute error, or NaN if no cell was scored."""
        return float(np.percentile(np.abs(self.errors_m), 95.0)) if self.judged.any() else float("nan")

    @property
    def best_order(self) -> Order | None:
        """The strictest order of IHO S-44 whose vertical uncertainty limit is met by 95 % of the cells."""
        return best_order(self.errors_m, self.depths_m)


def compare_seabed(
    world: _core.World, rays: _core.RayScene, grid: DepthGrid, area_world_m: NDArray[np.float64]
) -> SeabedComparison:
    """Compare cells whose centres lie in the polygon (k, 2) with the mean terrain height in each cell.

    Terrain heights and obstacles are sampled at most SAMPLE_SPACING_M apart, including the cell's edges.
    """
    rows, columns = np.nonzero(grid.count)
    centres = np.stack([grid.west_m + (columns + 0.5) * grid.cell_m, grid.south_m + (rows + 0.5) * grid.cell_m], axis=1)
    within = inside(centres, area_world_m)
    rows, columns, centres = rows[within], columns[within], centres[within]
    vertices, triangles, _ = world.surface_mesh(with_terrain=False)
    may_be_blocked = _near(vertices[triangles], grid)[rows, columns]
    height = np.empty(len(centres))
    for batch, xy in _samples(centres, grid.cell_m):
        height[batch] = world.height_at(xy).reshape(len(height[batch]), -1).mean(axis=1)
    blocked = np.zeros(len(centres), bool)
    heights_m = np.array([0.0, world.lowest_m, world.highest_m, *vertices[:, 2]])
    heights_m = heights_m[np.isfinite(heights_m)]  # without a terrain, heights are not finite
    top_m, bottom_m = float(heights_m.max()), float(heights_m.min())
    blocked[may_be_blocked] = _blocked(rays, centres[may_be_blocked], grid.cell_m, top_m, bottom_m)
    error, true_depth = np.full(grid.depth_m.shape, np.nan), np.full(grid.depth_m.shape, np.nan)
    obstructed = np.zeros(grid.depth_m.shape, bool)
    true_depth[rows, columns] = -height
    obstructed[rows, columns] = blocked
    error[rows, columns] = np.where(blocked, np.nan, grid.depth_m[rows, columns] + height)
    return SeabedComparison(grid, error, true_depth, obstructed)


def _near(triangles_m: NDArray[np.float64], grid: DepthGrid) -> NDArray[np.bool_]:
    """Return the cells (rows, columns) in or next to the bounding box of a triangle (n, 3, 3), where solids may be."""
    rows, columns = grid.depth_m.shape
    at = (triangles_m[..., :2] - (grid.west_m, grid.south_m)) / grid.cell_m
    low, high = np.floor(at.min(axis=1)).astype(np.int64) - 1, np.floor(at.max(axis=1)).astype(np.int64) + 2
    (west, south), (east, north) = np.clip(low, 0, (columns, rows)).T, np.clip(high, 0, (columns, rows)).T
    boxes = np.zeros((rows + 1, columns + 1), np.int64)  # cumulative sums give the number of boxes at each cell
    for row, column, sign in ((south, west, 1), (north, east, 1), (south, east, -1), (north, west, -1)):
        np.add.at(boxes, (row, column), sign)
    return np.asarray(boxes.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0)


def _samples(centres_m: NDArray[np.float64], cell_m: float) -> Iterator[tuple[slice, NDArray[np.float64]]]:
    """Yield batches of cells with their sample points (n, 2), the same number for each cell."""
    steps = int(np.ceil(cell_m / SAMPLE_SPACING_M - 1e-9)) + 1
    offset = (np.linspace(-0.5, 0.5, steps)) * cell_m
    offsets = np.stack(np.meshgrid(offset, offset), axis=-1).reshape(-1, 2)
    cells_at_once = max(SAMPLES_AT_ONCE // len(offsets), 1)
    for start in range(0, len(centres_m), cells_at_once):
        batch = slice(start, min(start + cells_at_once, len(centres_m)))
        yield batch, (centres_m[batch, None] + offsets).reshape(-1, 2)


def _blocked(
    rays: _core.RayScene, centres_m: NDArray[np.float64], cell_m: float, top_m: float, bottom_m: float
) -> NDArray[np.bool_]:
    """Return a mask (n,) of cells in which an obstacle is the first hit below any sample.

    top_m, bottom_m: heights of the highest and lowest points in the world.
    """
    blocked = np.zeros(len(centres_m), bool)
    for batch, xy in _samples(centres_m, cell_m):
        origins = np.column_stack([xy, np.full(len(xy), top_m + MARGIN_M)])
        down = np.broadcast_to([0.0, 0.0, -1.0], origins.shape)
        first = rays.cast(origins, down, top_m - bottom_m + 2.0 * MARGIN_M)
        obstacle = np.isfinite(first.ranges_m) & (first.labels != TERRAIN_LABEL)
        blocked[batch] = obstacle.reshape(len(blocked[batch]), -1).any(axis=1)
    return blocked
