"""Geometry of polygons: self-intersection, area and smallest width."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

Point = tuple[float, float]


def crossing_edges(corners: Sequence[Point]) -> tuple[int, int] | None:
    """Return two edges that cross, touch or fold back, as indices of their first corners; None for a simple polygon."""
    n = len(corners)
    edges = [(corners[k], corners[(k + 1) % n]) for k in range(n)]
    for i in range(n):
        for j in range(i + 1, n):
            if j == i + 1 or (i == 0 and j == n - 1):
                first, second = (edges[i], edges[j]) if j == i + 1 else (edges[j], edges[i])
                if _folds_back(first[0], first[1], second[1]):
                    return i, j
            elif _meet(*edges[i], *edges[j]):
                return i, j
    return None


def area(corners: Sequence[Point]) -> float:
    """Return the area of a simple polygon, whose corners may be in either order."""
    x, y = np.asarray(corners, np.float64).T
    x, y = x - x[0], y - y[0]  # avoids cancellation far from the origin
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


def narrowest_width(corners: Sequence[Point]) -> float:
    """Return the smallest distance between two parallel lines that enclose the polygon.

    One of the lines runs along an edge of the convex hull (Houle and Toussaint 1988), and so through two corners.
    """
    points = np.asarray(corners, np.float64)
    first, second = np.triu_indices(len(points), 1)
    along = points[second] - points[first]
    along = along[along.any(axis=1)]
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
    return float(np.ptp(normals @ (points - points[0]).T, axis=1).min())


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _folds_back(a: Point, b: Point, c: Point) -> bool:
    """Return whether the edge from b to c runs back along the edge from a to b, or one of them has no length."""
    along = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1])
    return a == b or b == c or (_turn(a, b, c) == 0.0 and along < 0.0)


def _meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    t1, t2, t3, t4 = _turn(a, b, c), _turn(a, b, d), _turn(c, d, a), _turn(c, d, b)
    if t1 * t2 < 0 and t3 * t4 < 0:
        return True
    touching = ((t1, a, b, c), (t2, a, b, d), (t3, c, d, a), (t4, c, d, b))
    return any(turn == 0 and _within(p, q, r) for turn, p, q, r in touching)


def _within(p: Point, q: Point, r: Point) -> bool:
    """Return whether r lies in the box spanned by p and q."""
    return all(min(p[k], q[k]) <= r[k] <= max(p[k], q[k]) for k in (0, 1))
