"""Point-cloud processing with PCL: downsampling, outlier removal, ground-plane detection.

    points_m = voxel_grid(points_m, 0.1)
    points_m = remove_outliers(points_m, neighbours=16, deviations=2.0)
    ground = ground_plane(points_m, distance_m=0.2)

Points are (n, 3) float32. C-ordered float32 arrays are not copied, float64 arrays and sequences are converted, and
other dtypes are rejected. The same points in the same order give the same bytes. All errors are ValueError. Calls
release the GIL.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core


@dataclass(frozen=True, eq=False)
class GroundPlane:
    """The plane normal . p + offset_m = 0. normal: (3,), unit, pointing up. inliers: (n,) bool, the points on it."""

    normal: NDArray[np.float64]
    offset_m: float
    inliers: NDArray[np.bool_]

    def height_of(self, points_m: ArrayLike) -> NDArray[np.float64]:
        """Return the signed distances (n,) of points (n, 3) above the plane [m]."""
        return np.asarray(np.asarray(points_m, np.float64) @ self.normal + self.offset_m, np.float64)


def voxel_grid(points_m: ArrayLike, voxel_m: float) -> NDArray[np.float32]:
    """Return the centroid of the points in each non-empty cube of edge voxel_m: (k, 3) float32.

    Cube corners are at multiples of voxel_m, as in OctoMap. Non-finite points are discarded. Raises ValueError
    if the cloud's bounding box contains 2**31 cubes or more.
    """
    return _core.voxel_grid(points_m, voxel_m)


def pass_through(
    points_m: ArrayLike, axis: Literal["x", "y", "z"], min_m: float = -math.inf, max_m: float = math.inf
) -> NDArray[np.float32]:
    """Return the points whose coordinate on the axis is in [min_m, max_m]. Non-finite points are discarded."""
    if axis not in ("x", "y", "z"):
        raise ValueError(f"axis = {axis!r}: must be 'x', 'y' or 'z'")
    return _core.pass_through(points_m, "xyz".index(axis), min_m, max_m)


def remove_outliers(points_m: ArrayLike, neighbours: int = 16, deviations: float = 2.0) -> NDArray[np.float32]:
    """Return the points without outliers (Rusu et al. 2008, "Towards 3D point cloud based object maps").

    A point is an outlier if the mean distance to its nearest `neighbours` points exceeds the mean of that distance over
    the cloud by more than `deviations` standard deviations. Non-finite points are discarded. There must be more points
    than neighbours.
    """
    return _core.remove_outliers(points_m, neighbours, deviations)


def ground_plane(points_m: ArrayLike, distance_m: float, max_slope_rad: float = math.radians(30.0)) -> GroundPlane:
    """Return the plane with the most points within distance_m (RANSAC, Fischler and Bolles 1981, then least squares).

    max_slope_rad: the steepest slope that counts as ground, to exclude walls. PCL's random numbers have a fixed seed,
    so the same points give the same plane. Raises ValueError if a point is not finite or there is no such plane.
    """
    return GroundPlane(*_core.ground_plane(points_m, distance_m, max_slope_rad))
