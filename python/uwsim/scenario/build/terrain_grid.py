"""The grid of a terrain, and interpolation of other grids at its nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal

import numpy as np
from numpy.typing import NDArray

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
