"""Samples a body as points and a path as poses, the input with which `OccupancyMap.bodies_blocked` checks a path."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

TILT = 1e-7  # offset of the lattice, in spacings, so that its lines pass through no vertex or edge


def body_points(
    vertices_m: NDArray[np.float64], triangles: NDArray[np.integer], spacing_m: float
) -> NDArray[np.float64]:
    """Return points (k, 3) that fill a closed mesh: a lattice of spacing_m inside it, and points on its surface.

    No point of the body is farther than spacing_m from the nearest of these. vertices_m: (n, 3), as from
    `uwsim.scenario.vehicle_hull`. triangles: (m, 3). Raises ValueError for a spacing that is not positive or that would
    give more than ten million points.
    """
    if not spacing_m > 0:
        raise ValueError(f"spacing_m = {spacing_m} m: must be positive")
    corners = np.asarray(vertices_m, np.float64)[triangles]
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    if np.prod((high - low) / spacing_m + 1.0) > 1e7:
        raise ValueError(f"spacing_m = {spacing_m} m: gives more than ten million points")
    return np.concatenate([_inside(corners, low, high, spacing_m), _on_triangles(corners, spacing_m)])


def _inside(
    corners: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64], spacing_m: float
) -> NDArray[np.float64]:
    """Return the lattice points inside the mesh: those below an odd number of its triangles."""
    x, y, z = (np.arange(a + 0.5 * spacing_m, b, spacing_m) for a, b in zip(low, high, strict=True))
    found = [np.empty((0, 3))]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area = _cross(b - a, c - a)
    upright = area == 0.0
    for at_x in x:
        for at_y in y:
            point = np.array([at_x + TILT * spacing_m, at_y + np.pi * TILT * spacing_m])
            u, v = _cross(c - b, point - b[:, :2]), _cross(a - c, point - c[:, :2])
            w = area - u - v
            hit = ~upright & (np.sign(u) * np.sign(v) > 0) & (np.sign(v) * np.sign(w) > 0)
            heights = (u[hit] * a[hit, 2] + v[hit] * b[hit, 2] + w[hit] * c[hit, 2]) / area[hit]
            above = (heights[:, None] > z).sum(axis=0)
            inside = z[above % 2 == 1]
            found.append(np.column_stack([np.full(len(inside), at_x), np.full(len(inside), at_y), inside]))
    return np.concatenate(found)


def _cross(p: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    return p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]


def _on_triangles(corners: NDArray[np.float64], spacing_m: float) -> NDArray[np.float64]:
    """Return points on triangles (m, 3, 3), at most spacing_m apart on each triangle."""
    edges_m = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.maximum(1, np.ceil(edges_m / spacing_m)).astype(int)
    found = []
    for count in np.unique(parts):
        i, j = np.mgrid[0 : count + 1, 0 : count + 1]
        u, v = i[i + j <= count] / count, j[i + j <= count] / count
        weights = np.column_stack([1.0 - u - v, u, v])
        found.append(np.einsum("kw,mwd->mkd", weights, corners[parts == count]).reshape(-1, 3))
    return np.unique(np.concatenate(found), axis=0)


def poses_along(
    positions_world_m: ArrayLike, orientations_xyzw: ArrayLike, reach_m: float, step_m: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return positions (n, 3) and orientations (n, 4) along a path, close enough that points of a body move little.

    positions_world_m: (m, 3), m >= 2, joined by straight lines. orientations_xyzw: (m, 4), joined by turns about a
    fixed axis. reach_m: distance of the body's farthest point from its origin. step_m: how far a point may move between
    poses.
    """
    from scipy.spatial.transform import Rotation, Slerp  # takes a while to import

    positions = np.asarray(positions_world_m, np.float64)
    turns = Rotation.from_quat(np.asarray(orientations_xyzw, np.float64))
    if positions.ndim != 2 or positions.shape[1:] != (3,) or len(positions) < 2 or len(positions) != len(turns):
        raise ValueError(f"positions_world_m.shape = {positions.shape}: must be (m, 3), m >= 2, with m orientations")
    if not (step_m > 0 and reach_m >= 0):
        raise ValueError(f"step_m = {step_m} m, reach_m = {reach_m} m: must be positive")
    moves_m = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    angles = (turns[:-1].inv() * turns[1:]).magnitude()
    parts = np.maximum(1, np.ceil((moves_m + reach_m * angles) / step_m)).astype(int)
    at = np.concatenate([k + np.arange(count) / count for k, count in enumerate(parts)] + [[float(len(parts))]])
    knots = np.arange(len(positions), dtype=float)
    along = np.column_stack([np.interp(at, knots, positions[:, axis]) for axis in range(3)])
    return along, Slerp(knots, turns)(at).as_quat()
