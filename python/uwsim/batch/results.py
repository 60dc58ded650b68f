"""Results of a batch, as arrays with one row per member that are allocated once and overwritten by each call."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.named import Named
from uwsim.base.short_repr import ShortRepr

R = TypeVar("R")


@dataclass(frozen=True, eq=False, repr=False)
class BatchMotion(ShortRepr):
    """Pose and velocity of one vehicle in each member. The arrays are read-only and belong to the batch.

    time_ns (n,) uint64: time since the member's start. position_world_m (n, 3), orientation_xyzw (n, 4), velocity_body
    (n, 6) [m/s, rad/s]: float64. collisions (n,) uint64: number of contacts begun so far. released (n,) bool.
    """

    time_ns: NDArray[np.uint64]
    position_world_m: Floats
    orientation_xyzw: Floats
    velocity_body: Floats
    collisions: NDArray[np.uint64]
    released: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, repr=False)
class BatchEstimate(ShortRepr):
    """The estimated motion of one vehicle in each member. The arrays belong to the caller; see Vehicle.estimate.

    float64: time_s (n,), the time of the estimate; position_world_m (n, 3), orientation_xyzw (n, 4), velocity_body (n,
    6) [m/s, rad/s]; covariance (n, 15, 15), see Navigator.covariance.
    """

    time_s: Floats
    position_world_m: Floats
    orientation_xyzw: Floats
    velocity_body: Floats
    covariance: Floats


@dataclass(frozen=True, eq=False, repr=False)
class BatchObject(ShortRepr):
    """Pose and velocity of one object in each member. The arrays belong to the caller.

    position_world_m (n, 3), of its middle; orientation_xyzw (n, 4); velocity_body (n, 6) [m/s, rad/s]: float64.
    """

    position_world_m: Floats
    orientation_xyzw: Floats
    velocity_body: Floats


@dataclass(frozen=True, eq=False, repr=False)
class BatchJoints(ShortRepr):
    """The joints of one arm or object in each member; see Arm.read. The arrays belong to the caller.

    names: of the joints that move. positions, speeds, motor_torques (n, joints) float64: hinges in rad, rad/s and N m,
    slides in m, m/s and N.
    """

    names: tuple[str, ...]
    positions: Floats
    speeds: Floats
    motor_torques: Floats


@dataclass(frozen=True, eq=False, repr=False)
class BatchSamples(ShortRepr):
    """The latest sample from one sensor in each member; see Sensor.read. The read-only arrays belong to the batch.

    values (n, width) float64: all fields, concatenated. fields: one view per field, (n,) or (n, width). stamp_ns (n,)
    uint64: the time of the measurement. valid (n,) bool.
    """

    values: Floats
    stamp_ns: NDArray[np.uint64]
    valid: NDArray[np.bool_]
    fields: Mapping[str, Floats]


@dataclass(frozen=True, eq=False, repr=False)
class BatchPings(ShortRepr):
    """A ping from one sonar in each member; see Ping. The arrays are read-only and belong to the batch.

    (n, beams): ranges_m, incidence_rad, intensity_db float32, labels uint16, valid bool; points_sonar_m (n, beams, 3)
    float32; world_from_sonar (n, 4, 4) float64.
    """

    ranges_m: NDArray[np.float32]
    points_sonar_m: NDArray[np.float32]
    incidence_rad: NDArray[np.float32]
    intensity_db: NDArray[np.float32]
    labels: NDArray[np.uint16]
    valid: NDArray[np.bool_]
    world_from_sonar: Floats


@dataclass(frozen=True, eq=False, repr=False)
class BatchPhysicsPings(BatchPings):
    """A physics-mode ping from one sonar in each member, with the additional arrays of _core.PhysicsPing.

    (n, beams): snr_db, travel_time_s, deviation_m, vertical_deviation_m, horizontal_deviation_m float32, detections
    uint8.
    """

    snr_db: NDArray[np.float32]
    travel_time_s: NDArray[np.float32]
    deviation_m: NDArray[np.float32]
    vertical_deviation_m: NDArray[np.float32]
    horizontal_deviation_m: NDArray[np.float32]
    detections: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Buffers(Generic[R]):
    """The arrays that the core fills, in the order that it expects, and a read-only result that exposes them."""

    writable: tuple[NDArray[Any], ...]
    shown: R


def motion_buffers(n: int) -> Buffers[BatchMotion]:
    """Allocate the arrays for the motion of n members."""
    shapes = ((n,), np.uint64), ((n, 3), float), ((n, 4), float), ((n, 6), float), ((n,), np.uint64), ((n,), np.bool_)
    writable = _arrays(*shapes)
    return Buffers(writable, BatchMotion(*map(_read_only, writable)))


def sample_buffers(n: int, fields: Mapping[str, tuple[int, str]]) -> Buffers[BatchSamples]:
    """Allocate the arrays for samples of n members. fields: (width, unit) by name."""
    writable = _arrays(((n, sum(width for width, _ in fields.values())), float), ((n,), np.uint64), ((n,), np.bool_))
    values, stamps, valid = map(_read_only, writable)
    views: dict[str, Floats] = {}
    first = 0
    for name, (width, _) in fields.items():
        views[name] = values[:, first] if width == 1 else values[:, first : first + width]
        first += width
    return Buffers(writable, BatchSamples(values, stamps, valid, Named(views, "fields")))


def ping_buffers(n: int, beams: int, in_physics_mode: bool) -> Buffers[BatchPings]:
    """Allocate the arrays for pings of n members."""
    fan, floats = (n, beams), np.float32
    echoes = _arrays(
        (fan, floats), ((*fan, 3), floats), (fan, floats), (fan, floats), (fan, np.uint16), (fan, np.bool_)
    )
    heads = _arrays(((n, 4, 4), float))
    if not in_physics_mode:
        return Buffers((*echoes, *heads), BatchPings(*map(_read_only, (*echoes, *heads))))
    detector = _arrays(*[(fan, floats)] * 5, (fan, np.uint8))
    shown = BatchPhysicsPings(*map(_read_only, (*echoes, *heads, *detector)))
    return Buffers((*echoes, *detector, *heads), shown)


def _arrays(*shapes: tuple[tuple[int, ...], Any]) -> tuple[NDArray[Any], ...]:
    return tuple(np.zeros(shape, dtype) for shape, dtype in shapes)


def _read_only(array: NDArray[Any]) -> NDArray[Any]:
    view = array.view()
    view.flags.writeable = False
    return view
