"""Division of a survey area into tiles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from manifold3d import CrossSection, FillRule
from numpy.typing import NDArray

from uwsim.scenario.spec.survey import area, narrowest_width

Corners = tuple[tuple[float, float], ...]
TILES = "tiles"
"""The folder of the tiles' files."""
MAX_TILES = 1_000_000
LEAST_WIDTH_VOXELS, LEAST_AREA_VOXELS = 4, 40
"""Smaller pieces, which occur along the area's edge, are left out."""


@dataclass(frozen=True)
class Tile:
    """A part of the area surveyed by one vehicle. area_m: its corners, (x, y). cell: its grid square, (i, j).

    Tiles share a cell if the outline of the area cuts a square into several pieces.
    """

    number: int
    cell: tuple[int, int]
    area_m: Corners

    def file(self, out: Path, suffix: str) -> Path:
        """Return a file in a fleet's folder: .ot, the map with all log-odds; .npy, the sonar's positions (n, 3)."""
        return out / TILES / f"{self.number:06d}{suffix}"


@dataclass(frozen=True)
class Grid:
    """A grid over the bounding box of an area.

    low_m: lower corner (x, y) of the box. edge_m: cell size (x, y), at most the requested length. count: number of
    cells along x and y.
    """

    low_m: tuple[float, float]
    edge_m: tuple[float, float]
    count: tuple[int, int]

    def cells_of(self, points_m: NDArray[np.floating]) -> NDArray[np.int64]:
        """Return the cells (n, 2) of points (n, 2 or more); points outside are assigned to the nearest cell."""
        cells = np.floor((points_m[:, :2] - self.low_m) / self.edge_m).astype(np.int64)
        return np.asarray(np.clip(cells, 0, np.array(self.count) - 1))

    def corners(self, cell: tuple[int, int]) -> Corners:
        """Return the corners of a cell, counterclockwise."""
        (x, y), (dx, dy) = self.low_m, self.edge_m
        i, j = cell
        return tuple((x + (i + a) * dx, y + (j + b) * dy) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)))


def grid_over(area_m: Corners, tile_m: float) -> Grid:
    """Return a grid of cells of about tile_m that exactly covers the bounding box. Raises ValueError."""
    low, high = np.min(area_m, axis=0), np.max(area_m, axis=0)
    across, up = (max(1, math.ceil(size / tile_m - 1e-9)) for size in (high - low).tolist())
    if across * up > MAX_TILES:
        raise ValueError(f"tile_m = {tile_m:g} m: makes {across * up:,} tiles, must be at most {MAX_TILES:,}")
    edge = (high - low) / (across, up)
    return Grid((float(low[0]), float(low[1])), (float(edge[0]), float(edge[1])), (across, up))


def tiles_of(area_m: Corners, grid: Grid, voxel_m: float) -> tuple[list[Tile], float]:
    """Return the tiles of a simple polygon, and the area [m2] of the slivers that were omitted."""
    whole = CrossSection([np.asarray(area_m, np.float64)], fillrule=FillRule.EvenOdd)
    tiles, left_m2 = list[Tile](), 0.0
    for j in range(grid.count[1]):
        for i in range(grid.count[0]):
            square = CrossSection([np.asarray(grid.corners((i, j)), np.float64)])
            for part in (whole ^ square).to_polygons():
                corners = tuple((float(x), float(y)) for x, y in part)
                if len(corners) < 3:
                    continue
                wide = narrowest_width(corners) >= LEAST_WIDTH_VOXELS * voxel_m
                if wide and area(corners) >= LEAST_AREA_VOXELS * voxel_m**2:
                    tiles.append(Tile(len(tiles), (i, j), corners))
                else:
                    left_m2 += area(corners)
    return tiles, left_m2
