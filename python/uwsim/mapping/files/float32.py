"""Rounding to float32, for formats that may store no more precision."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FINEST_M = 1e-3


def rounded(points_m: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return finite points (n, 3), little-endian and C-ordered: float32, as most programs expect.

    float64 if that would move a point by more than a millimetre, as it does 16 km from zero, in georeferenced clouds.
    """
    with np.errstate(over="ignore"):
        single = np.ascontiguousarray(points_m, "<f4")
    return single if np.abs(single - points_m).max() <= FINEST_M else np.ascontiguousarray(points_m, "<f8")
