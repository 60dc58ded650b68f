"""The terrain as heights on a regular grid, from any source that a scenario may specify."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.scenario.build.strokes import with_strokes
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.terrain import MAX_NODES, TerrainModel


@dataclass(frozen=True, eq=False)
class Terrain:
    """Terrain heights. heights_m: (ny, nx) float32, finite; heights_m[j, i] is z at (x0 + i spacing, y0 + j spacing).

    origin_m: (x0, y0). World frame; the water surface is at z = 0.
    """

    heights_m: NDArray[np.float32]
    spacing_m: float
    origin_m: tuple[float, float]

    @property
    def extent_m(self) -> tuple[float, float, float, float]:
        """The bounds of the grid: (x0, y0, x1, y1)."""
        ny, nx = self.heights_m.shape
        x0, y0 = self.origin_m
        return x0, y0, x0 + (nx - 1) * self.spacing_m, y0 + (ny - 1) * self.spacing_m

    @property
    def extent_text(self) -> str:
        """The bounds as text for messages."""
        x0, y0, x1, y1 = self.extent_m
        return f"which reaches from x = {x0:g} to {x1:g} m and from y = {y0:g} to {y1:g} m"

    @property
    def lowest_m(self) -> float:
        """Height (z) of the deepest point."""
        return float(self.heights_m.min())

    def window(self, corners_m: tuple[tuple[float, float], tuple[float, float]] | None) -> Terrain:
        """Return the part of the terrain whose cells cover a box with these corners (x, y), or all of it for None.

        Raises ScenarioError if the box is outside.
        """
        if corners_m is None:
            return self
        ny, nx = self.heights_m.shape
        cells = (np.array(corners_m) - self.origin_m) / self.spacing_m
        (i0, j0), (i1, j1) = np.clip(np.floor(cells[0]), 0, (nx, ny)), np.clip(np.ceil(cells[1]), -1, (nx - 1, ny - 1))
        if i1 <= i0 or j1 <= j0:
            raise ScenarioError(f"terrain.window_m: is outside the terrain, {self.extent_text}")
        rows, columns = slice(int(j0), int(j1) + 1), slice(int(i0), int(i1) + 1)
        origin_m = (self.origin_m[0] + i0 * self.spacing_m, self.origin_m[1] + j0 * self.spacing_m)
        return Terrain(np.ascontiguousarray(self.heights_m[rows, columns]), self.spacing_m, origin_m)

    def height_at(self, xy_m: ArrayLike) -> NDArray[np.float64]:
        """Return z (n,) of the triangulated surface at points (n, 2); NaN outside the terrain.

        Each cell is split along the diagonal from (i + 1, j) to (i, j + 1), as in the native world.
        """
        xy = np.asarray(xy_m, np.float64).reshape(-1, 2)
        ny, nx = self.heights_m.shape
        u, v = ((xy - self.origin_m) / self.spacing_m).T
        inside = (u >= 0) & (u <= nx - 1) & (v >= 0) & (v <= ny - 1)
        i = np.clip(np.nan_to_num(u), 0, nx - 2).astype(int)
        j = np.clip(np.nan_to_num(v), 0, ny - 2).astype(int)
        u, v = u - i, v - j
        h00, h10, h01, h11 = (
            self.heights_m[j + up, i + right].astype(np.float64) for up, right in ((0, 0), (0, 1), (1, 0), (1, 1))
        )
        lower = h00 + u * (h10 - h00) + v * (h01 - h00)
        upper = h11 + (1 - u) * (h01 - h11) + (1 - v) * (h10 - h11)
        return np.where(inside, np.where(u + v <= 1, lower, upper), np.nan)


def build_terrain(spec: TerrainModel) -> Terrain:
    """Return a terrain's heights, centred on the world's origin. Raises ScenarioError.

    With the same build of the libraries, the same spec produces the same bytes.
    """
    heights = np.asarray(spec.heights())
    if heights.ndim != 2 or min(heights.shape) < 2 or heights.size > MAX_NODES:
        raise ScenarioError(f"terrain: heights of shape {heights.shape}: must be 2 x 2 to {MAX_NODES} nodes")
    heights = np.ascontiguousarray(with_strokes(heights, spec.strokes, spec.spacing_m), np.float32)
    if not np.isfinite(heights).all():
        raise ScenarioError(f"terrain: {np.count_nonzero(~np.isfinite(heights))} heights are not finite")
    ny, nx = heights.shape
    origin = (-(nx - 1) * spec.spacing_m / 2, -(ny - 1) * spec.spacing_m / 2)
    return Terrain(heights, spec.spacing_m, origin)
