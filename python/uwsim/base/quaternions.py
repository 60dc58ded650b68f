"""Single rotations as quaternions (x, y, z, w).

For a single rotation, SciPy's Rotation takes 20 us and this module 1 us. Importing SciPy takes longer than creating a
simulator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray


def product(first_xyzw: ArrayLike, then_xyzw: ArrayLike) -> NDArray[np.float64]:
    """Return the Hamilton product (4,) of two unit quaternions, such as a_from_c from a_from_b and b_from_c.

    The first may be n quaternions (n, 4); so is the result then.
    """
    first = np.asarray(first_xyzw, np.float64)
    x, y, z, w = first.T if first.ndim == 2 else first.tolist()
    p, q, r, s = np.asarray(then_xyzw, np.float64).tolist()
    return np.array([
        w * p + x * s + y * r - z * q,
        w * q - x * r + y * s + z * p,
        w * r + x * q - y * p + z * s,
        w * s - x * p - y * q - z * r,
    ]).T  # fmt: skip


def of_yaw_pitch_roll_deg(angles_deg: Sequence[float]) -> NDArray[np.float64]:
    """Return the rotation by yaw about z, then pitch about the new y, then roll about the new x, (4,)."""
    yaw, pitch, roll = np.radians(np.asarray(angles_deg, np.float64)).tolist()
    return product(product(about_z(yaw), about_y(pitch)), about_x(roll))


def to_yaw_pitch_roll_deg(xyzw: ArrayLike) -> tuple[float, float, float]:
    """Return a rotation's angles as of_yaw_pitch_roll_deg takes them: yaw and roll within 180, pitch within 90 degrees.

    At a pitch of 90 degrees only yaw and roll together are defined.
    """
    r = matrix(xyzw)
    yaw, roll = math.atan2(r[1, 0], r[0, 0]), math.atan2(r[2, 1], r[2, 2])
    return math.degrees(yaw), math.degrees(math.atan2(-r[2, 0], math.hypot(r[0, 0], r[1, 0]))), math.degrees(roll)


def turned_deg(own_deg: Sequence[float], turn_deg: Sequence[float]) -> tuple[float, float, float]:
    """Return yaw, pitch and roll of what has the first ones and is then turned by the second ones in the world."""
    if turn_deg[1] == 0.0 == turn_deg[2]:  # without rounding
        return within_half_turn_deg(own_deg[0] + turn_deg[0]), own_deg[1], own_deg[2]
    return to_yaw_pitch_roll_deg(product(of_yaw_pitch_roll_deg(turn_deg), of_yaw_pitch_roll_deg(own_deg)))


def within_half_turn_deg(angle_deg: float) -> float:
    """Return the same direction from -180 to below 180 degrees."""
    return (angle_deg + 180.0) % 360.0 - 180.0


def matrix(xyzw: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation as a matrix (3, 3)."""
    x, y, z, w = np.asarray(xyzw, np.float64).tolist()
    return np.array([
        [x * x - y * y - z * z + w * w, 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), -x * x + y * y - z * z + w * w, 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), -x * x - y * y + z * z + w * w],
    ])  # fmt: skip


def of_matrix(rotation: ArrayLike) -> NDArray[np.float64]:
    """Return the quaternion (4,) of a rotation matrix (3, 3): the root of its largest component, and quotients.

    Source: S. W. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1(3), 1978.
    """
    (a, b, c), (d, e, f), (g, h, i) = np.asarray(rotation, np.float64).tolist()
    squares = (1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i, 1.0 + a + e + i)
    largest = max(range(4), key=squares.__getitem__)
    found = (
        (squares[0], b + d, c + g, h - f),
        (b + d, squares[1], f + h, c - g),
        (c + g, f + h, squares[2], d - b),
        (h - f, c - g, d - b, squares[3]),
    )[largest]
    return np.array(found) * (0.5 / math.sqrt(squares[largest]))


def turned(xyzw: ArrayLike, points: ArrayLike) -> NDArray[np.float64]:
    """Return rotated points, (3,) or (n, 3)."""
    # With BLAS, rounding may depend on the number of points; einsum does not use BLAS.
    result: NDArray[np.float64] = np.einsum("jk,...k->...j", matrix(xyzw), np.asarray(points, np.float64))
    return result


def about_x(angle_rad: float) -> NDArray[np.float64]:
    """Return the rotation about x, (4,)."""
    return np.array([math.sin(0.5 * angle_rad), 0.0, 0.0, math.cos(0.5 * angle_rad)])


def about_y(angle_rad: float) -> NDArray[np.float64]:
    """Return the rotation about y, (4,)."""
    return np.array([0.0, math.sin(0.5 * angle_rad), 0.0, math.cos(0.5 * angle_rad)])


def about_z(angle_rad: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation about z, (4,), or (n, 4) by n angles."""
    if isinstance(angle_rad, np.ndarray):
        return np.array([about_z(each) for each in angle_rad.tolist()])  # as sines of the C library
    return np.array([0.0, 0.0, math.sin(0.5 * angle_rad), math.cos(0.5 * angle_rad)])


def heading_rad(orientation_xyzw: ArrayLike) -> float:
    """Return the direction of the rotated x axis in the x-y plane, anticlockwise from x."""
    x, y, z, w = np.asarray(orientation_xyzw, np.float64).tolist()
    return math.atan2(2.0 * (x * y + z * w), w * w + x * x - y * y - z * z)
