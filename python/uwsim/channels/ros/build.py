"""Helpers that build messages from arrays: headers, times, poses and transforms.

Given columns, they build one message that stands for n: see `columns`. Times are then (n,), vectors (n, 3), quaternions
(n, 4), and a vector's part may be a column, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache, lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.base.quaternions import product
from uwsim.channels.ros.message_out import default_message, default_value
from uwsim.channels.ros.message_types import fields as fields_of
from uwsim.channels.ros.message_types import typestore

IDENTITY_XYZW = (0.0, 0.0, 0.0, 1.0)
# Rotations from an instrument's frame to its mount's (x ahead, y left, z up).
OPTICAL_XYZW = (-0.5, 0.5, -0.5, 0.5)  # camera, REP 103: x right, y down, z ahead
DOWN_XYZW = (1.0, 0.0, 0.0, 0.0)  # DVL, marine_acoustic_msgs/Dvl: x ahead, z along its beams
FAN_XYZW = (0.5**0.5, 0.0, 0.5**0.5, 0.0)  # imaging sonar, marine_acoustic_msgs/ProjectedSonarImage: x up, z ahead


def message(name: str, /, **fields: Any) -> Any:
    """Return a message of a type such as "sensor_msgs/msg/Imu". Omitted fields get their ROS defaults."""
    cls, defaults = _plan(name)
    if len(fields) == len(defaults):
        try:
            return cls(**fields)
        except TypeError:  # an unknown field
            pass
    if unknown := fields.keys() - defaults.keys():
        raise AttributeError(f"{name}: has no field {min(unknown)!r}")
    for field, make in defaults.items():
        if field not in fields:
            fields[field] = make()
    return cls(**fields)


@cache
def _plan(name: str) -> tuple[Callable[..., Any], dict[str, Callable[[], Any]]]:
    """Return a type's class and, for each field, a factory that creates its default value."""
    if not fields_of(name, 2):
        return (lambda: default_message(name)), {}
    made: dict[str, Callable[[], Any]] = {
        field.attribute: partial(default_value, field.kind) for field in fields_of(name, 2) if field.attribute
    }
    return typestore().types[name], made


@cache
def _class(name: str) -> Callable[..., Any]:
    """Return a type's class, for the parts of almost all messages. Arguments: all fields in order."""
    return _plan(name)[0]


def time(stamp_ns: int | NDArray[np.uint64]) -> Any:
    """Return a builtin_interfaces/Time."""
    ns = stamp_ns.astype(np.int64) if isinstance(stamp_ns, np.ndarray) else int(stamp_ns)
    sec, nanosec = divmod(ns, 1_000_000_000)
    return _class("builtin_interfaces/msg/Time")(sec, nanosec)


def ns_of(stamp: Any) -> int:
    """Return the nanoseconds of a builtin_interfaces/Time."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def duration(duration_s: float) -> Any:
    """Return a duration."""
    sec, nanosec = divmod(round(1e9 * duration_s), 1_000_000_000)
    return message("builtin_interfaces/msg/Duration", sec=sec, nanosec=nanosec)


def header(stamp_ns: int | NDArray[np.uint64], frame_id: str) -> Any:
    """Return a std_msgs/Header."""
    return _class("std_msgs/msg/Header")(time(stamp_ns), frame_id)


def text(data: str) -> Any:
    """Return a std_msgs/String."""
    return message("std_msgs/msg/String", data=data)


def xyz(name: str, values: ArrayLike) -> Any:
    """Return a message with fields x, y and z, such as geometry_msgs/msg/Point, from (3,)."""
    return _class(name)(*_parts(values))


def vector(values: ArrayLike) -> Any:
    """Return a geometry_msgs/Vector3 from (3,)."""
    return xyz("geometry_msgs/msg/Vector3", values)


def quaternion(orientation_xyzw: ArrayLike) -> Any:
    """Return a geometry_msgs/Quaternion from (4,)."""
    return _class("geometry_msgs/msg/Quaternion")(*_parts(orientation_xyzw))


def _parts(values: ArrayLike) -> Iterable[Any]:
    """Return the components of a vector, each a float or a column."""
    if isinstance(values, tuple):
        return values
    array = np.asarray(values, np.float64)
    return array.T if array.ndim == 2 else array.tolist()


def pose(position_m: ArrayLike, orientation_xyzw: ArrayLike) -> Any:
    """Return a geometry_msgs/Pose."""
    position = xyz("geometry_msgs/msg/Point", position_m)
    return _class("geometry_msgs/msg/Pose")(position, quaternion(orientation_xyzw))


def transform(
    stamp_ns: int | NDArray[np.uint64],
    parent: str,
    child: str,
    position_m: ArrayLike,
    orientation_xyzw: ArrayLike = IDENTITY_XYZW,
) -> Any:
    """Return the geometry_msgs/TransformStamped parent_from_child."""
    moved = _class("geometry_msgs/msg/Transform")(vector(position_m), quaternion(orientation_xyzw))
    return _class("geometry_msgs/msg/TransformStamped")(header(stamp_ns, parent), child, moved)


def turned_xyzw(first_xyzw: ArrayLike, then_xyzw: ArrayLike) -> NDArray[np.float64]:
    """Return the product of two rotations as a quaternion (4,)."""
    return product(first_xyzw, then_xyzw)


@lru_cache(256)  # a head stands still for most of the time
def tilt_xyzw(elevation_rad: float) -> tuple[float, float, float, float]:
    """Return the rotation about y of a sonar head that is tilted to an elevation (positive: nose up)."""
    half = -0.5 * elevation_rad
    return 0.0, float(np.sin(half)), 0.0, float(np.cos(half))


def tilts_xyzw(elevations_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return `tilt_xyzw` of each, (n, 4)."""
    return np.array([tilt_xyzw(each) for each in elevations_rad.tolist()])
