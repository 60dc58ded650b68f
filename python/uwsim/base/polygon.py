"""Polygons in a plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats


def inside(points: NDArray[np.floating], corners: Floats) -> NDArray[np.bool_]:
    """Return a mask (n,) of points (n, 2 or more) inside a polygon (m, 2) of either winding, by the even-odd rule."""
    x, y = points[:, 0], points[:, 1]
    inside = np.zeros(len(points), np.bool_)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return inside


def is_crossed(corners: Floats, start: Floats, end: Floats) -> bool:
    """Return whether a line from start (2,) to end (2,) crosses a side of a polygon (m, 2).

    The ends of the line lie on different sides of the polygon's side, and the ends of that on different sides of the
    line, by the signs of cross products.
    """
    left, right = corners, np.roll(corners, -1, axis=0)
    of_line = _cross(end - start, left - start) * _cross(end - start, right - start)
    of_side = _cross(right - left, start - left) * _cross(right - left, end - left)
    return bool(((of_line < 0) & (of_side < 0)).any())


def _cross(a: Floats, b: Floats) -> Floats:
    found: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return found
