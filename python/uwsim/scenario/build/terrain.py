"""The terrain as heights on a regular grid, from any source that a scenario may specify, with strokes of a brush."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.terrain import MAX_NODES, Stroke, TerrainModel

FloatGrid = NDArray[np.float64]
PixelAt = Callable[[FloatGrid, FloatGrid], tuple[FloatGrid, FloatGrid]]

BLOCK_NODES = 1 << 20
NODE_TOLERANCE = 1e-6  # fraction of a cell; rounding moves a node by less
SPLINE_MARGIN = 12  # number of copies of the edge values, as SciPy pads


def grid_axes(size_m: tuple[float, float], spacing_m: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the coordinates x (nx,) and y (ny,) of the nodes, centred on zero."""

    def axis(size: float) -> NDArray[np.float64]:
        count = round(size / spacing_m) + 1
        return np.asarray((np.arange(count) - (count - 1) / 2) * spacing_m, np.float64)

    return axis(size_m[0]), axis(size_m[1])


def perlin_step(share: FloatGrid) -> FloatGrid:
    """Return Perlin's step (2002) from 0 at a share of 0 to 1 at 1.

    Its second derivative is continuous, which avoids a crease in a bed, which would produce echoes.
    """
    t = np.clip(share, 0, 1)
    return np.asarray(t**3 * (t * (6 * t - 15) + 10))


def resampled(
    values: FloatGrid, x: FloatGrid, y: FloatGrid, pixel_at: PixelAt, interpolation: Literal["cubic", "linear"]
) -> FloatGrid:
    """Interpolate values (h, w) at the nodes (ny, nx) of a grid, linearly or with an interpolating cubic spline.

    pixel_at: converts coordinates to fractional rows and columns. It is called block by block, since converting all
    nodes of a large terrain at once would take a gigabyte of memory.
    """
    from scipy.ndimage import map_coordinates, spline_filter  # imported here: slow to import

    order = 3 if interpolation == "cubic" and min(values.shape) > 3 else 1
    margin = SPLINE_MARGIN if order > 1 else 0
    known = spline_filter(np.pad(values, margin, mode="edge"), order, mode="nearest") if order > 1 else values
    result = np.empty((len(y), len(x)))
    for across, down in _blocks(len(x), len(y)):
        rows, columns = pixel_at(*np.meshgrid(x[across], y[down]))
        places = [rows + margin, columns + margin]
        result[down, across] = map_coordinates(known, places, order=order, mode="nearest", prefilter=False)
    return result


def pixel_ranges(x: FloatGrid, y: FloatGrid, pixel_at: PixelAt) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the first and last row and the first and last column that linear interpolation at the nodes uses."""
    lowest, highest = np.full(2, np.inf), np.zeros(2)
    for across, down in _blocks(len(x), len(y)):
        for axis, places in enumerate(pixel_at(*np.meshgrid(x[across], y[down]))):
            lowest[axis], highest[axis] = min(lowest[axis], places.min()), max(highest[axis], places.max())
    first, last = np.floor(np.maximum(lowest + NODE_TOLERANCE, 0)), np.ceil(highest - NODE_TOLERANCE)
    return (int(first[0]), int(last[0])), (int(first[1]), int(last[1]))


def _blocks(nx: int, ny: int) -> Iterator[tuple[slice, slice]]:
    """Yield slices of columns and rows that tile a grid."""
    width = min(nx, BLOCK_NODES)
    height = max(BLOCK_NODES // width, 1)
    for top in range(0, ny, height):
        for left in range(0, nx, width):
            yield slice(left, left + width), slice(top, top + height)


def with_strokes(heights_m: NDArray[np.floating], strokes: Sequence[Stroke], spacing_m: float) -> NDArray[np.floating]:
    """Return heights (ny, nx) of a grid centred on the world's origin with strokes, one after another."""
    if not strokes:
        return heights_m
    drawn = heights_m.astype(np.float64)
    for stroke in strokes:
        _draw(drawn, stroke, spacing_m)
    return drawn


def _draw(heights: FloatGrid, stroke: Stroke, spacing_m: float) -> None:
    reach = stroke.width_m / 2 / spacing_m  # in cells, as all below
    line = np.asarray(stroke.line_m) / spacing_m + (np.array(heights.shape[::-1]) - 1) / 2
    rows, columns = _near(line, reach, heights.shape)
    drawn = heights[rows, columns]
    if drawn.size == 0:
        return
    line -= (columns.start, rows.start)
    away = np.full(drawn.shape, np.inf)
    for start, end in zip(line[[0, *range(len(line) - 1)]], line, strict=True):
        part = _near(np.stack([start, end]), reach, drawn.shape)
        y, x = np.ogrid[part]
        way = end - start
        share = np.clip(((x - start[0]) * way[0] + (y - start[1]) * way[1]) / max(way @ way, 1e-12), 0, 1)
        distance = np.hypot(x - start[0] - share * way[0], y - start[1] - share * way[1])
        away[part] = np.minimum(away[part], distance)
    weight = perlin_step(1 - away / reach)
    if stroke.smooth > 0:
        drawn += stroke.smooth * weight * (_mean(heights, rows, columns, reach) - drawn)
    drawn += stroke.height_m * weight


def _near(points: FloatGrid, reach: float, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Return the rows and the columns of a grid within reach of a box around points (n, 2); empty ones outside."""
    low = np.clip(np.floor(points.min(axis=0) - reach), 0, shape[::-1]).astype(int)
    high = np.clip(np.ceil(points.max(axis=0) + reach) + 1, 0, shape[::-1]).astype(int)
    return slice(low[1], high[1]), slice(low[0], high[0])


def _mean(heights: FloatGrid, rows: slice, columns: slice, reach: float) -> FloatGrid:
    """Return the mean of a part's neighbours within half the reach along each axis, the nearest repeated at edges."""
    from scipy.ndimage import uniform_filter  # here: slow to import

    half = max(round(reach / 2), 1)
    top, left = max(rows.start - half, 0), max(columns.start - half, 0)
    mean = uniform_filter(heights[top : rows.stop + half, left : columns.stop + half], 2 * half + 1, mode="nearest")
    return np.asarray(mean[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left])


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
