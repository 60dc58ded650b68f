"""The path of a ray through layered water, for drawing."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

LEAST_1_S = 1e-7  # weaker gradients are treated as this one, an arc of 1e10 m
STEEPEST_RAD = 0.5 * math.pi - 1e-9
POINTS_PER_ARC = 8
MOST_ARCS = 20_000


def ray_path(
    profile: ArrayLike, bottom_depth_m: float, source_depth_m: float, launch_rad: float, range_m: float
) -> NDArray[np.float64]:
    """Return points (n, 2) of distance and depth [m] along a ray, from its source to a distance.

    profile: as for arrivals(). bottom_depth_m: where rays reflect; may be infinite. launch_rad: below the horizontal.
    By Snell's law, cos(dip) / c = p: in a layer whose speed of sound has the gradient g, the distance grows by
    (sin dip - sin dip') / (p g) and the depth by (cos dip' - cos dip) / (p g) between two dips.
    """
    depths_m, speeds_m_s = _levels(np.asarray(profile, float), bottom_depth_m, source_depth_m)
    dip = float(np.clip(launch_rad, -STEEPEST_RAD, STEEPEST_RAD))
    k = int(np.searchsorted(depths_m, source_depth_m, "right" if dip > 0 else "left")) - 1
    k = min(max(k, 0), len(depths_m) - 2)
    p = math.cos(dip) / float(np.interp(source_depth_m, depths_m, speeds_m_s))
    points = [(0.0, source_depth_m)]
    for _ in range(MOST_ARCS):
        (x, depth), edge = points[-1], k + 1 if dip > 0 else k
        gradient = (speeds_m_s[k + 1] - speeds_m_s[k]) / (depths_m[k + 1] - depths_m[k])
        bend = p * math.copysign(max(abs(gradient), LEAST_1_S), gradient)
        turns = p * speeds_m_s[edge] >= 1.0
        at_edge = -dip if turns else math.copysign(math.acos(p * speeds_m_s[edge]), dip)
        if abs(gradient) < LEAST_1_S:
            at_edge = math.copysign(math.acos(min(1.0, math.cos(dip) + bend * (depths_m[edge] - depth))), dip)
        at_range = math.sin(dip) - bend * (range_m - x)
        ends = abs(at_range) <= 1.0 and (math.sin(dip) - math.sin(at_edge)) / bend >= range_m - x
        end = math.asin(at_range) if ends else at_edge
        dips = np.linspace(dip, end, POINTS_PER_ARC + 1)[1:]
        across = x + (math.sin(dip) - np.sin(dips)) / bend
        lower = depth + (np.cos(dips) - math.cos(dip)) / bend
        points += zip(across.tolist(), lower.tolist(), strict=True)
        if ends:
            break
        dip = end
        if turns:
            continue
        points[-1] = (points[-1][0], depths_m[edge])
        if edge in (0, len(depths_m) - 1):
            dip = -dip
        else:
            k = edge if dip > 0 else edge - 1
    return np.array(points)


def _levels(
    profile: NDArray[np.float64], bottom_depth_m: float, source_depth_m: float
) -> tuple[list[float], list[float]]:
    """Return depths and speeds from the surface to the bottom, or to far below all levels."""
    last = bottom_depth_m if math.isfinite(bottom_depth_m) else max(float(profile[-1, 0]), source_depth_m) + 1e6
    inner = profile[(profile[:, 0] > 0.0) & (profile[:, 0] < last), 0]
    depths_m = [0.0, *inner.tolist(), last]
    return depths_m, np.interp(depths_m, profile[:, 0], profile[:, 1]).tolist()
