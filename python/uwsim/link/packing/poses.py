"""Packings of poses, velocities and the published `key` message."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from uwsim.channels import Channel
from uwsim.channels.ros import build

POSE = struct.Struct("<3i4h")  # mm, and 1/32767 of a unit quaternion's components
KEY = struct.Struct("<6bB")  # efforts in 1/127 of full effort; the function
TWIST = struct.Struct("<6h")
TWIST_QUANTUM = 0.005  # m/s, rad/s
INT32, INT16 = 2**31 - 1, 2**15 - 1


def pack_pose(message: Any) -> bytes:
    """Pack a pose into 20 bytes: the position in mm, the quaternion to 3e-5."""
    at, turned = message.position, message.orientation
    position = np.clip(np.round(1e3 * np.array([at.x, at.y, at.z])), -INT32, INT32).astype(int)
    turn = np.round(INT16 * np.clip([turned.x, turned.y, turned.z, turned.w], -1.0, 1.0)).astype(int)
    return POSE.pack(*position, *turn)


def unpack_pose(data: bytes, channel: Channel) -> Any:
    """Return the pose message."""
    values = POSE.unpack(data)
    turn = np.array(values[3:], np.float64)
    return build.pose(np.array(values[:3]) * 1e-3, turn / (np.linalg.norm(turn) or 1.0))


def pack_key(message: Any) -> bytes:
    """Pack a key message into 7 bytes: six efforts, clipped to [-1, 1], and the function number."""
    linear, angular = message.position, message.orientation
    efforts = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
    if not np.isfinite(efforts).all():
        raise ValueError(f"key: efforts = {efforts}: must be finite")
    if angular.w not in range(256):
        raise ValueError(f"key: orientation.w = {angular.w:g}: must be a function")
    return KEY.pack(*np.round(127 * np.clip(efforts, -1.0, 1.0)).astype(int), int(angular.w))


def unpack_key(data: bytes, channel: Channel) -> Any:
    """Return the key message."""
    values = KEY.unpack(data)
    efforts = [value / 127 for value in values[:6]]
    return build.pose(np.array(efforts[:3]), np.array([*efforts[3:], float(values[6])]))


def is_plain_key(message: Any) -> bool:
    """Return whether a key message contains only efforts.

    Such a message may be replaced; a function must not be lost.
    """
    return bool(message.orientation.w == 0)


def pack_twist(message: Any) -> bytes:
    """Pack velocities into 12 bytes, in steps of 5 mm/s and 5 mrad/s."""
    linear, angular = message.linear, message.angular
    values = np.array([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])
    if not (np.abs(values) <= INT16 * TWIST_QUANTUM).all():
        raise ValueError(f"velocity = {values.tolist()}: must be finite and within {INT16 * TWIST_QUANTUM:g}")
    return TWIST.pack(*np.round(values / TWIST_QUANTUM).astype(int))


def unpack_twist(data: bytes, channel: Channel) -> Any:
    """Return the velocity message."""
    values = np.array(TWIST.unpack(data)) * TWIST_QUANTUM
    return build.message("geometry_msgs/msg/Twist", linear=build.vector(values[:3]), angular=build.vector(values[3:]))
