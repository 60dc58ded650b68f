"""Deterministic points distributed evenly over the surface of a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
PLASTIC = 1.324717957244746
"""The plastic number, whose powers define the R2 sequence: Roberts 2018, "The unreasonable effectiveness of quasirandom
sequences"."""


def surface_points(vertices_m: Floats, triangles: NDArray[np.integer], count: int = 4000) -> Floats:
    """Return points (count, 3) on the triangles (m, 3) of vertices (n, 3), each representing an equal area."""
    a, b, c = (vertices_m[triangles[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    upto = np.cumsum(areas)
    places = (np.arange(count) + 0.5) / count * upto[-1]
    chosen = np.minimum(np.searchsorted(upto, places), len(areas) - 1)
    u, v = (np.modf(0.5 + np.arange(1, count + 1) / PLASTIC**k)[0] for k in (1, 2))
    outside = u + v > 1.0
    u, v = np.where(outside, 1.0 - u, u), np.where(outside, 1.0 - v, v)
    a, b, c = a[chosen], b[chosen], c[chosen]
    return np.asarray(a + u[:, None] * (b - a) + v[:, None] * (c - a), np.float64)
