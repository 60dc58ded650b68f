"""Rectification: the picture that a pinhole camera would have taken, computed from a distorted picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.base import lens_model
from uwsim.base.arrays import Floats


def rectify(rgb: NDArray[np.uint8], k: Floats, d: Floats, p: Floats) -> NDArray[np.uint8]:
    """Return a picture (h, w, 3) as seen through the pinhole with the projection matrix p (3, 4).

    As ROS's image_proc and OpenCV's initUndistortRectifyMap do: each pixel of the result is interpolated linearly at
    the point to which k (3, 3) and d (see uwsim.base.lens_model) project its ray; black beyond the picture.
    """
    if not d.any() and np.array_equal(k, p[:, :3]):
        return rgb
    height, width = rgb.shape[:2]
    u, v = project(*np.meshgrid(np.arange(width), np.arange(height)), k, d, p)
    left, top = np.floor(u).astype(np.int32), np.floor(v).astype(np.int32)
    right_share, lower_share = (u - left)[..., None], (v - top)[..., None]
    # A border of one black pixel represents everything beyond the picture.
    padded = np.pad(rgb.astype(np.float32), ((1, 1), (1, 1), (0, 0)))

    def at(column: NDArray[np.int32], row: NDArray[np.int32]) -> NDArray[np.float32]:
        return padded[np.clip(row + 1, 0, height + 1), np.clip(column + 1, 0, width + 1)]

    upper = at(left, top) * (1 - right_share) + at(left + 1, top) * right_share
    lower = at(left, top + 1) * (1 - right_share) + at(left + 1, top + 1) * right_share
    return np.asarray(np.rint(upper * (1 - lower_share) + lower * lower_share), np.uint8)


def project(
    u: NDArray[np.int64], v: NDArray[np.int64], k: Floats, d: Floats, p: Floats
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the pixels of a lens with k and d that see the rays through pixels (u, v) of the pinhole p."""
    left, top = lens_model.project(k, d, (u - p[0, 2]) / p[0, 0], (v - p[1, 2]) / p[1, 1])
    return left.astype(np.float32), top.astype(np.float32)
