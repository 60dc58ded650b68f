"""Sonar poses as matrices (4, 4), world from sonar."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from uwsim.base import quaternions
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import about_x, about_y, about_z, product

POSE_TOLERANCE = 1e-6  # maximum deviation of a pose's rotation from orthogonality


def pose_matrix(
    position_m: Iterable[float] = (0.0, 0.0, 0.0),
    *,
    yaw_rad: float = 0.0,
    pitch_rad: float = 0.0,
    roll_rad: float = 0.0,
) -> Floats:
    """Return the pose (4, 4) with this position, rotated about z, then the new y (nose down), then the new x.

    Raises ValueError if a value is not finite.
    """
    matrix = np.eye(4)
    turns = np.array([yaw_rad, pitch_rad, roll_rad], np.float64)
    if not np.isfinite(turns).all():
        raise ValueError(f"yaw, pitch, roll = {turns} rad: must be finite")
    yaw, pitch, roll = turns.tolist()
    matrix[:3, :3] = quaternions.matrix(product(product(about_z(yaw), about_y(pitch)), about_x(roll)))
    matrix[:3, 3] = np.asarray(list(position_m), np.float64)
    return checked_pose(matrix)


def checked_pose(pose: ArrayLike, name: str = "world_from_sonar") -> Floats:
    """Return the pose as (4, 4) float64. Raises ValueError unless its rotation and position are finite and valid."""
    matrix = np.asarray(pose, np.float64)
    if matrix.shape != (4, 4):
        raise ValueError(f"{name}.shape = {matrix.shape}: expected (4, 4)")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name}: must be finite")
    turn = matrix[:3, :3]
    off = max(float(np.abs(turn @ turn.T - np.eye(3)).max()), float(np.abs(matrix[3] - (0, 0, 0, 1)).max()))
    if off > POSE_TOLERANCE or np.linalg.det(turn) < 0:
        raise ValueError(f"{name}: must be a rotation and a position, with 0, 0, 0, 1 as the last row")
    return matrix


def split_poses(poses: Floats) -> tuple[Floats, Floats]:
    """Return the positions (n, 3) and quaternions (n, 4) of poses (n, 4, 4), for the native core."""
    from scipy.spatial.transform import Rotation  # slow to import

    turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat() if len(poses) else np.zeros((0, 4))
    return np.ascontiguousarray(poses[:, :3, 3]), turns
