"""Matches two submaps of the same ground, and derives the uncertainty of the match from the shape of the ground.

Point-to-plane registration (Chen and Medioni 1992, "Object modelling by registration of multiple range images") with
rotation about the vertical only, since roll and pitch are known from gravity. Points may slide along a surface, as is
unavoidable on a smooth bed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.closure.submaps import CELL_M, Submap

Array = NDArray[np.float64]
POINTS = 600  # points taken from the second cloud, evenly sampled
REACHES_M, ITERATIONS = (4.0, 1.5), 8  # points farther apart are ignored; steps for each reach
STILL_M = 1e-3
LEAST_OVERLAP, MOST_OFF_M = 0.4, 0.3  # least share of points within reach; largest RMS distance from the planes
POINTS_PER_LOOK = 10.0  # points that share one error (assumed): those in a beam's footprint over several pings
LEAST_STD_M, LEAST_STD_RAD = 0.15, 3e-3  # smallest uncertainty of a match, assumed: about the distortion of a submap


@dataclass(frozen=True, eq=False)
class Match:
    """A match of two submaps: point here_m (2,) in submap `first` is point there_m (2,) in submap `second`.

    turn_rad: rotation from the second onto the first. covariance: (3, 3), of x, y [m] and rotation [rad].
    """

    first: int
    second: int
    here_m: Array
    there_m: Array
    turn_rad: float
    covariance: Array


@dataclass(eq=False)
class _Fit:
    """The state of a registration.

    moved_m: the source points in their current position. turn_rad: total rotation. overlap: share of these points
    within reach of the target. off_m: RMS distance from the planes. information: (4, 4), of x, y, rotation and z.
    """

    moved_m: Array
    turn_rad: float = 0.0
    overlap: float = 0.0
    off_m: float = np.inf
    information: Array | None = None


def match(maps: list[Submap], first: int, second: int) -> Match | None:
    """Match two submaps, starting from their estimated poses; return None if they do not match or lack features."""
    source = _common(maps[second], maps[first])
    if len(source) < POINTS // 10:
        return None
    fit = _Fit(source)
    for reach_m in REACHES_M:
        for _ in range(ITERATIONS):
            step_m = _improve(fit, maps[first], reach_m)
            if step_m is None:
                return None
            if step_m < STILL_M:
                break
    if fit.overlap < LEAST_OVERLAP or fit.off_m > MOST_OFF_M or fit.information is None:
        return None
    least = np.diag([LEAST_STD_M**2, LEAST_STD_M**2, LEAST_STD_RAD**2])
    covariance = np.asarray(np.linalg.inv(fit.information)[:3, :3] + least)
    here, there = fit.moved_m[:, :2].mean(axis=0), source[:, :2].mean(axis=0)
    return Match(first, second, here, there, fit.turn_rad, covariance)


def _improve(fit: _Fit, target: Submap, reach_m: float) -> float | None:
    """Take one Gauss-Newton step; return its length [m], or None if the planes do not determine it."""
    distances, nearest = target.tree.query(fit.moved_m, distance_upper_bound=reach_m)
    near = np.isfinite(distances)
    fit.overlap = float(near.mean())
    if near.sum() < POINTS // 10:
        return None
    points, nearest = fit.moved_m[near], nearest[near]
    normals, centre = target.normals[nearest], fit.moved_m.mean(axis=0)
    arm = points - centre
    lever = normals[:, 1] * arm[:, 0] - normals[:, 0] * arm[:, 1]
    jacobian = np.column_stack([normals[:, :2], lever, normals[:, 2]])
    off = np.einsum("ni,ni->n", normals, points - target.points_world_m[nearest])
    spread = max(1.48 * float(np.median(np.abs(off))), 1e-3)
    weights = 1.0 / (1.0 + (off / (2.0 * spread)) ** 2)  # Cauchy
    normal_matrix = jacobian.T @ (weights[:, None] * jacobian)
    if np.linalg.cond(normal_matrix) > 1e10:
        return None
    x, y, turn, z = np.linalg.solve(normal_matrix, -jacobian.T @ (weights * off))
    cos, sin = np.cos(turn), np.sin(turn)
    fit.moved_m = (fit.moved_m - centre) @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + centre + [x, y, z]
    fit.turn_rad += float(turn)
    fit.off_m = float(np.sqrt(np.average(off**2, weights=weights)))
    fit.information = normal_matrix / (max(fit.off_m, 0.01) ** 2 * POINTS_PER_LOOK)
    return float(np.linalg.norm([x, y, z]))


def _common(submap: Submap, other: Submap) -> Array:
    """Return about POINTS points of a submap that lie within the horizontal extent of another."""
    cells = np.floor(submap.points_world_m[:, :2] / CELL_M).astype(np.int64).tolist()
    common = submap.points_world_m[[tuple(cell) in other.cells for cell in cells]]
    return np.asarray(common[:: max(1, len(common) // POINTS)], np.float64)
