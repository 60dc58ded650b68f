"""A vehicle's command channels: /cmd_vel, wrench, thruster and fin commands, sonar tilt and an arm's joints."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.commands import COMMANDS, Argument
from uwsim.channels.authority.joint_motion import JointMotion, Limits, Trajectory, trajectory_of
from uwsim.channels.authority.steering import Steering
from uwsim.channels.channel import COMMAND, Authority, Channel, OverLink, ended_by
from uwsim.channels.families.body_frames import body_frames
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

SPEED_MAX = 100.0  # m/s and rad/s
FLOATS = "std_msgs/msg/Float64MultiArray"
THRUSTER = COMMANDS["set_thrusters"].argument("commands")
FIN = COMMANDS["set_fins"].argument("angles_rad")
ELEVATION = COMMANDS["aim"].argument("elevation_rad")
CONTROLLER = "arm_controller"  # that ros2_control's examples and MoveIt's have
JOINT, JOINTS = COMMANDS["set_joints"].argument("positions"), "sensor_msgs/msg/JointState"


def command_channels(source: Source, sim: Simulator, steering: Steering) -> list[Channel]:
    """Return a vehicle's standard command channels. Each steering command replaces the previous one."""
    vehicle, topic, frame_id = source.of(sim), source.topic, source.frame("base_link")
    thrusters, fins = list(vehicle.thrusters), list(vehicle.fins)

    def inbound(
        name: str, kind: str, description: str, apply: Any, *, idle: Any = None, packing: str = "deflate"
    ) -> Channel:
        """Return an inbound channel. idle: the message that ends a steering command."""
        return Channel(
            topic(name), kind, "in", description, frame_id=frame_id, over_link=OverLink(COMMAND, packing),
            apply=apply, authority=Authority() if idle is None else ended_by(idle, apply),
        )  # fmt: skip

    found = [
        inbound(
            "cmd_vel", "geometry_msgs/msg/Twist", "velocity [m/s, rad/s] in body axes, held until the next command",
            lambda live, message: steering.hold_velocity(live, six("cmd_vel", message.linear, message.angular)),
            idle=build.message("geometry_msgs/msg/Twist"), packing="twist",
        ),
        inbound(
            "cmd_wrench", "geometry_msgs/msg/Wrench", "force [N] and torque [N m] of the thrusters in still water",
            lambda live, message: _wrench(live, steering, message), idle=build.message("geometry_msgs/msg/Wrench"),
        ),
    ]  # fmt: skip
    if thrusters:
        found.append(
            inbound(
                "cmd_thrusters", FLOATS, f"commands in [-1, 1]: {', '.join(thrusters)}",
                lambda live, message: steering.give(
                    live, "set_thrusters", commands=_named("cmd_thrusters", thrusters, message.data, THRUSTER)
                ),
                idle=build.message(FLOATS, data=np.zeros(len(thrusters))),
            )
        )  # fmt: skip
    if fins:
        found.append(
            inbound(
                "cmd_fins", FLOATS, f"deflections [rad]: {', '.join(fins)}",
                lambda live, message: steering.give(
                    live, "set_fins", angles_rad=_named("cmd_fins", fins, message.data, FIN)
                ),
                idle=build.message(FLOATS, data=np.zeros(len(fins))),
            )
        )  # fmt: skip
    if source.has_sonar:
        found.append(
            inbound(
                "cmd_tilt", "std_msgs/msg/Float64", "sonar_tilt [rad] to turn to, positive: nose down",
                lambda live, message: _tilt(live, steering, message.data),
            )
        )  # fmt: skip
    motors = () if vehicle.arm is None else vehicle.arm.motors
    if motors:
        found.append(
            inbound(
                "cmd_joints", JOINTS, f"positions, velocities or efforts of {', '.join(motors)}",
                lambda live, message: _command_joints(live, steering, _joints(message, source, motors)),
            )
        )  # fmt: skip
        limits = joint_limits(source, motors)
        found.append(
            inbound(
                f"{CONTROLLER}/joint_trajectory", "trajectory_msgs/msg/JointTrajectory",
                f"points through which joints move: {', '.join(motors)}",
                lambda live, message: _follow(live, steering, source, trajectory_of(message, source, limits)),
            )
        )  # fmt: skip
    return found


def six(topic: str, first: Any, second: Any, limit: float = SPEED_MAX) -> NDArray[np.float64]:
    """Return two vectors as (6,). Raises ValueError, with the topic's name, beyond the limit."""
    values = np.array([first.x, first.y, first.z, second.x, second.y, second.z], np.float64)
    if not np.isfinite(values).all() or np.abs(values).max() > limit:
        raise ValueError(f"{topic} = {values.tolist()}: must be finite and within {limit:g}")
    return values


def _wrench(live: LiveSimulator, steering: Steering, message: Any) -> None:
    wrench = six("cmd_wrench", message.force, message.torque, limit=1e9)
    steering.give(live, "set_wrench", force_body_n=wrench[:3], torque_body_nm=wrench[3:])


def _named(topic: str, names: Sequence[str], values: NDArray[np.float64], each: Argument) -> dict[str, float]:
    if len(values) != len(names):
        raise ValueError(f"{topic}: {len(values)} values: must be {len(names)}: {', '.join(names)}")
    for name, value in zip(names, values, strict=True):
        each.check_number(value, f"{topic}: {name}")
    return dict(zip(names, map(float, values), strict=True))


def _joints(message: Any, source: Source, motors: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the arguments of set_joints: one of the message's arrays, by joint. Raises ValueError."""
    given = {
        to: np.asarray(getattr(message, field), np.float64)
        for field, to in (("position", "positions"), ("velocity", "speeds"), ("effort", "torques"))
        if len(getattr(message, field))
    }
    if len(given) != 1:
        raise ValueError(f"cmd_joints: {len(given)} arrays: must have one of position, velocity and effort")
    ((to, values),) = given.items()
    by_topic = {source.topic(name): name for name in motors}  # as in joint_states
    names = [by_topic.get(name, name) for name in message.name]
    if len(names) != len(values):
        raise ValueError(f"cmd_joints: {len(values)} values: must be one for each of {len(names)} names")
    for name, value in zip(names, values, strict=True):
        if name not in motors:
            raise ValueError(f"cmd_joints: {name}: must be one of {', '.join(motors)}")
        JOINT.check_number(value, f"cmd_joints: {name}")
    return {to: dict(zip(names, map(float, values), strict=True))}


def joint_limits(source: Source, motors: Sequence[str]) -> dict[str, Limits]:
    """Return the limits of these joints of a vehicle."""
    joints = {frame.joint.name: frame.joint for frame in body_frames(source.entry.model) if frame.joint is not None}
    return {name: Limits(joints[name].low_rad, joints[name].high_rad, joints[name].rate_rad_s) for name in motors}


def _command_joints(live: LiveSimulator, steering: Steering, arguments: dict[str, dict[str, float]]) -> None:
    steering.move_joints(None)
    steering.ask(live, "set_joints", **arguments)


def _follow(live: LiveSimulator, steering: Steering, source: Source, trajectory: Trajectory) -> None:
    steering.move_joints(JointMotion(live, source, trajectory, partial(steering.ask, live, "set_joints")))


def _tilt(live: LiveSimulator, steering: Steering, tilt_rad: float) -> None:
    ELEVATION.check_number(tilt_rad, "cmd_tilt")
    steering.ask(live, "aim", elevation_rad=-tilt_rad)
