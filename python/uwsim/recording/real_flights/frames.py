"""An autopilot's frames: which servo output drives which thruster of a vehicle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from uwsim import _core

if TYPE_CHECKING:
    from uwsim.scenario.spec.actuator import ThrusterMount


class Factors(NamedTuple):
    """The effect of a motor at full command, in the autopilot's axes.

    Forces are forward, right (lateral) and up (throttle); moments are right-handed about the forward, right and down
    axes.
    """

    roll: int
    pitch: int
    yaw: int
    throttle: int
    forward: int
    lateral: int


_HORIZONTAL = (
    Factors(0, 0, 1, 0, -1, 1),
    Factors(0, 0, -1, 0, -1, -1),
    Factors(0, 0, -1, 0, 1, 1),
    Factors(0, 0, 1, 0, 1, -1),
)
FRAMES: Mapping[str, tuple[Factors, ...]] = {
    "vectored": (*_HORIZONTAL, Factors(1, 0, 0, -1, 0, 0), Factors(-1, 0, 0, -1, 0, 0)),
    "vectored_6dof": (
        *_HORIZONTAL,
        Factors(1, -1, 0, -1, 0, 0),
        Factors(-1, -1, 0, -1, 0, 0),
        Factors(1, 1, 0, -1, 0, 0),
        Factors(-1, 1, 0, -1, 0, 0),
    ),
}
"""ArduSub's frames (libraries/AP_Motors/AP_Motors6DOF.cpp): the factors of each motor, by servo output."""

ACROSS = 0.2
"""The largest share of a thrust that may act along an axis for which a motor's factor is 0."""


def frame_of(thrusters: Mapping[str, ThrusterMount], vehicle: str) -> str:
    """Return the name of the frame to which a vehicle's thrusters belong. Raises ValueError if there is none."""
    for name in FRAMES:
        if len(_fitting(name, thrusters)) == len(thrusters):
            return name
    raise ValueError(f"vehicle '{vehicle}': its thrusters fit none of ArduSub's frames {', '.join(FRAMES)}")


def servo_motors(frame: str, thrusters: Mapping[str, ThrusterMount], vehicle: str) -> list[_core.ServoMotor]:
    """Return which servo output drives which thruster, determined from the directions of forces and moments.

    Raises ValueError for an unknown frame, or one whose motors are arranged differently from the vehicle's.
    """
    if frame not in FRAMES:
        raise ValueError(f"frame = '{frame}': must be one of {', '.join(FRAMES)}")
    found, wanted = _fitting(frame, thrusters), len(FRAMES[frame])
    if not len(found) == wanted == len(thrusters):
        number = f"{len(thrusters)} thrusters of vehicle '{vehicle}'"
        raise ValueError(f"frame = '{frame}': has {wanted} motors, to which {len(found)} of the {number} correspond")
    return found


def _fitting(frame: str, thrusters: Mapping[str, ThrusterMount]) -> list[_core.ServoMotor]:
    """Return the motors that match exactly one thruster which, in turn, matches no other motor."""
    pairs = [
        (output, name, direction)
        for output, motor in enumerate(FRAMES[frame])
        for name, mount in thrusters.items()
        if (direction := _direction(motor, mount))
    ]
    outputs, names = [output for output, _, _ in pairs], [name for _, name, _ in pairs]
    alone = [pair for pair in pairs if outputs.count(pair[0]) == names.count(pair[1]) == 1]
    return [_core.ServoMotor(output, name, direction) for output, name, direction in alone]


def _direction(motor: Factors, mount: ThrusterMount) -> int:
    """Return the sign of a thruster's command for a positive motor command; 0 if their directions differ."""
    force = np.array(mount.axis) / np.linalg.norm(mount.axis)
    moment = np.cross(mount.position_m, force)
    acts = np.array([moment[0], -moment[1], -moment[2], force[2], force[0], -force[1]])
    factors = np.array(motor, np.float64)
    for sign in (1, -1):
        agrees = np.all(sign * acts[factors != 0] * factors[factors != 0] > 0)
        if agrees and np.all(np.abs(acts[3:][factors[3:] == 0]) <= ACROSS):
            return sign
    return 0
