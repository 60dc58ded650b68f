"""Rounding to float32, for formats that store no more precision."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def to_float32(points_m: NDArray[np.floating]) -> NDArray[np.float32]:
    """Return finite points (n, 3) rounded to little-endian float32, C-ordered. Raises ValueError on overflow."""
    with np.errstate(over="ignore"):
        rounded = np.ascontiguousarray(points_m, "<f4")
    if not np.isfinite(rounded).all():
        raise ValueError(f"points_m = up to {np.abs(points_m).max():g} m: must fit a float32")
    return rounded
