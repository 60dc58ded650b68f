"""The frames that a vehicle carries, from its model: sensors, sonars, cameras, thrusters, fins and links of an arm.

/tf, /tf_static, /joint_states and the URDF all take the names, positions and joints from here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.base.commands import COMMANDS
from uwsim.base.quaternions import of_yaw_pitch_roll_deg, turned
from uwsim.channels.ros import build
from uwsim.scenario.spec.arm import Link, links_in_order
from uwsim.scenario.spec.camera import CameraMount
from uwsim.scenario.spec.vehicle import VehicleModel

BASE, SCAN, SONAR_TILT = "base_link", "base_scan", "sonar_tilt"
ELEVATION = COMMANDS["aim"].argument("elevation_rad")
UNLIMITED = 1e3  # rad/s or N m, where URDF requires a limit and the model has none
PAN_AXIS, TILT_AXIS = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)


class Joint(NamedTuple):
    """A hinge, or a slide. name: as in /joint_states. axis: (3,), of length 1, in the frame that moves.

    Angles in rad and rad/s; a slide's are m and m/s instead. effort: the greatest, in N m or N.
    """

    name: str
    axis: tuple[float, float, float]
    low_rad: float
    high_rad: float
    rate_rad_s: float
    effort: float = UNLIMITED
    is_slide: bool = False


class Frame(NamedTuple):
    """A frame on a vehicle, without prefixes. position_m, orientation_xyzw: in the parent, with its joint at 0.

    is_described_only: whether the frame is in the URDF, but on /tf and /tf_static only on request.
    """

    parent: str
    name: str
    position_m: ArrayLike
    orientation_xyzw: ArrayLike = build.IDENTITY_XYZW
    joint: Joint | None = None
    is_described_only: bool = False

    def turned_xyzw(self, angle_rad: float) -> NDArray[np.float64]:
        """Return the orientation in the parent, (4,), with the joint at an angle."""
        assert self.joint is not None
        if self.joint.is_slide:
            return np.asarray(self.orientation_xyzw, np.float64)
        half = 0.5 * angle_rad
        turn = np.array([*np.multiply(math.sin(half), self.joint.axis), math.cos(half)])
        return build.turned_xyzw(self.orientation_xyzw, turn)

    def moved_m(self, travel_m: float) -> NDArray[np.float64]:
        """Return the position in the parent, (3,), with a slide at this travel; a hinge does not move it."""
        assert self.joint is not None
        if not self.joint.is_slide:
            return np.asarray(self.position_m, np.float64)
        moved = turned(self.orientation_xyzw, np.multiply(travel_m, self.joint.axis))
        return np.add(np.asarray(self.position_m, np.float64), moved)


def body_frames(model: VehicleModel) -> Iterator[Frame]:
    """Yield the frames of a vehicle, each after its parent; all are below base_link."""
    for name, sensor in model.sensors.items():
        turn = of_yaw_pitch_roll_deg(sensor.yaw_pitch_roll_deg)
        if sensor.kind in ("dvl", "adcp"):
            turn = build.turned_xyzw(turn, build.DOWN_XYZW)
        yield Frame(BASE, f"{name}_link", sensor.position_m, turn)
    for name, sonar in model.imaging_sonars.items():
        turn = build.turned_xyzw(of_yaw_pitch_roll_deg(sonar.yaw_pitch_roll_deg), build.FAN_XYZW)
        yield Frame(BASE, f"{name}_link", sonar.position_m, turn)
    for name, array in model.hydrophones.items():
        yield Frame(BASE, f"{name}_link", array.position_m, of_yaw_pitch_roll_deg(array.yaw_pitch_roll_deg))
    for name, camera in model.cameras.items():
        if camera.follows == "body":
            yield from _camera(name, camera)
    if model.sonar is not None:
        tilt = Joint(SONAR_TILT, TILT_AXIS, ELEVATION.low, ELEVATION.high, UNLIMITED)
        yield Frame(BASE, SCAN, model.sonar.position_m, joint=tilt)
    for name, thruster in model.thrusters.items():
        yield Frame(BASE, f"{name}_thruster_link", thruster.position_m, _x_along(thruster.axis), is_described_only=True)
    for name, fin in model.fins.items():
        if fin.deflection_max_deg == 0.0:
            continue
        limit, span = math.radians(fin.deflection_max_deg), np.divide(fin.span, np.linalg.norm(fin.span))
        x, y, z = span.tolist()
        hinge = Joint(name, (x, y, z), -limit, limit, math.radians(fin.rate_max_deg_s))
        yield Frame(BASE, f"{name}_fin_link", fin.position_m, joint=hinge, is_described_only=True)
    for name in links_in_order(model.arm or {}):
        yield _link(name, (model.arm or {})[name])


def link_frame(name: str) -> str:
    """Return the name of the frame of an arm's link."""
    return f"{name}_arm_link"


def _link(name: str, link: Link) -> Frame:
    joint = None
    if (hinge := link.hinge) is not None:
        low, high = (-math.inf, math.inf) if hinge.limits_deg is None else map(math.radians, hinge.limits_deg)
        rate, effort = (UNLIMITED, UNLIMITED)
        if hinge.motor is not None:
            rate, effort = math.radians(hinge.motor.fastest_deg_s), hinge.motor.strongest_nm
        joint = Joint(name, _unit(hinge.axis), low, high, rate, effort)
    elif (slide := link.slide) is not None:
        low_m, high_m = (-UNLIMITED, UNLIMITED) if slide.limits_m is None else slide.limits_m
        rate, effort = (UNLIMITED, UNLIMITED)
        if slide.motor is not None:
            rate, effort = slide.motor.fastest_m_s, slide.motor.strongest_n
        joint = Joint(name, _unit(slide.axis), low_m, high_m, rate, effort, is_slide=True)
    parent = BASE if link.on is None else link_frame(link.on)
    turn = of_yaw_pitch_roll_deg(link.yaw_pitch_roll_deg)
    return Frame(parent, link_frame(name), link.position_m, turn, joint, is_described_only=True)


def _unit(axis: ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.divide(axis, np.linalg.norm(axis)).tolist()
    return x, y, z


def _camera(name: str, camera: CameraMount) -> Iterator[Frame]:
    turn, motor = of_yaw_pitch_roll_deg(camera.yaw_pitch_roll_deg), camera.pan_tilt
    if motor is None:
        yield Frame(BASE, f"{name}_optical", camera.position_m, build.turned_xyzw(turn, build.OPTICAL_XYZW))
        return
    rate_rad_s = math.radians(motor.rate_deg_s)
    (left, right), (up, down) = np.radians([motor.pan_limits_deg, motor.tilt_limits_deg]).tolist()
    pan = Joint(f"{name}_pan", PAN_AXIS, left, right, rate_rad_s)
    tilt = Joint(f"{name}_tilt", TILT_AXIS, up, down, rate_rad_s)
    yield Frame(BASE, f"{name}_pan_link", camera.position_m, turn, pan, is_described_only=True)
    yield Frame(f"{name}_pan_link", f"{name}_tilt_link", np.zeros(3), joint=tilt, is_described_only=True)
    yield Frame(f"{name}_tilt_link", f"{name}_optical", np.zeros(3), build.OPTICAL_XYZW, is_described_only=True)


def _x_along(axis: ArrayLike) -> NDArray[np.float64]:
    """Return the smallest rotation (4,) that turns x to an axis of any length."""
    x, y, z = np.divide(axis, np.linalg.norm(axis)).tolist()
    if x < -1.0 + 1e-12:  # astern: half a turn about z
        return np.array([0.0, 0.0, 1.0, 0.0])
    turn = np.array([0.0, -z, y, 1.0 + x])  # the cross product of x and the axis
    return np.asarray(turn / np.linalg.norm(turn), np.float64)
