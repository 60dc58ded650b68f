"""Tests whether points lie inside a polygon, such as the area of a survey."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def inside_polygon(xy_m: NDArray[np.floating], polygon_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask (n,) of points (n, 2) inside a simple polygon (k, 2) of either winding, by the even-odd rule."""
    x, y = xy_m[:, 0], xy_m[:, 1]
    inside = np.zeros(len(xy_m), bool)
    for (x0, y0), (x1, y1) in zip(polygon_m, np.roll(polygon_m, -1, axis=0), strict=True):
        if y0 != y1:
            straddles = (y0 > y) != (y1 > y)
            inside ^= straddles & (x < x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return inside
