"""Depth, normals, labels and sonar levels as pixels of PNG files that any library can read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FARTHEST_M = 65.535
"""The largest depth in millimetres that fits into 16 bits."""


def depth_pixels(depth_m: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Return depth along the optical axis in mm, as in ScanNet, TUM and nerfstudio; 0: no hit, or beyond 65.535 m."""
    near = depth_m <= FARTHEST_M
    return np.where(near, np.rint(1000.0 * np.where(near, depth_m, 0.0)), 0).astype(np.uint16)


def normal_pixels(
    normals_world: NDArray[np.float32], world_from_optical: NDArray[np.float64], rays: NDArray[np.float32]
) -> NDArray[np.uint8]:
    """Return normals in the optical frame, facing the camera, as round(127.5 (n + 1)); 0, 0, 0 if nothing is hit.

    rays: (H, W, 2), X/Z and Y/Z of each pixel.
    """
    turn = world_from_optical[:3, :3].T.astype(np.float32)
    x, y, z = turn @ normals_world.reshape(-1, 3).T  # one array per axis, which is twice as fast in NumPy
    across, down = rays.reshape(-1, 2).T
    side = np.where(x * across + y * down + z > 0.0, np.float32(-127.5), np.float32(127.5))
    hit = (x != 0.0) | (y != 0.0) | (z != 0.0)
    pixels = np.empty((len(x), 3), np.uint8)
    for channel, values in enumerate((x, y, z)):
        pixels[:, channel] = np.rint(values * side + np.float32(127.5)) * hit
    return pixels.reshape(normals_world.shape)


def level_pixels(level_db: NDArray[np.float32], limits_db: tuple[float, float]) -> NDArray[np.uint8]:
    """Return grey levels, linear from the lower limit (black) to the upper limit (white)."""
    low, high = limits_db
    return np.asarray(np.rint(255.0 * np.clip((level_db - low) / (high - low), 0.0, 1.0)), np.uint8)
