"""A terrain's grid, and interpolation of other grids at its nodes."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatGrid = NDArray[np.float64]


def grid_axes(size_m: tuple[float, float], spacing_m: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return x (nx,) and y (ny,) of the nodes, centred on zero."""

    def axis(size: float) -> NDArray[np.float64]:
        count = round(size / spacing_m) + 1
        return np.asarray((np.arange(count) - (count - 1) / 2) * spacing_m, np.float64)

    return axis(size_m[0]), axis(size_m[1])


def interpolated(
    values: FloatGrid, rows: FloatGrid, columns: FloatGrid, interpolation: Literal["cubic", "linear"]
) -> FloatGrid:
    """Interpolate values (h, w) at fractional rows and columns, linearly or by a cubic spline through the values."""
    from scipy.ndimage import map_coordinates  # here, since it takes long to import

    order = 3 if interpolation == "cubic" and min(values.shape) > 3 else 1
    result: FloatGrid = map_coordinates(values, [rows, columns], order=order, mode="nearest", prefilter=order > 1)
    return result
