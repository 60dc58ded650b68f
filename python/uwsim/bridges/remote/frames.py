"""Conversion of times and poses in ROS messages to numbers and matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def seconds(stamp: Any) -> float:
    """Return a ROS time in seconds."""
    return int(stamp.sec) + 1e-9 * int(stamp.nanosec)


def vector(message: Any) -> NDArray[np.float64]:
    """Return x, y, z of a Vector3 or Point as (3,)."""
    return np.array([message.x, message.y, message.z], np.float64)


def quaternion(message: Any) -> NDArray[np.float64]:
    """Return a Quaternion as (4,): x, y, z, w."""
    return np.array([message.x, message.y, message.z, message.w], np.float64)


def matrix(position_m: NDArray[np.float64], orientation_xyzw: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a rigid transform as a matrix (4, 4)."""
    x, y, z, w = orientation_xyzw.tolist()
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = position_m
    return pose
