"""Further channels with the names and types that other stacks expect, for content that other channels have, too.

All are sent and recorded only on request. A Float64 for each thruster has neither time nor frame, and the commands of
one moment arrive as several messages: these topics are offered only with `thruster_topics`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from uwsim.base import quaternions
from uwsim.channels.authority.steering import ONE_THRUSTER, Steering
from uwsim.channels.channel import COMMAND, Authority, Channel, Delivery, OverLink, ended_by
from uwsim.channels.families.commands import THRUSTER, six
from uwsim.channels.families.covariance import isotropic
from uwsim.channels.families.instruments import DEFAULT_HZ, UNOBSERVED, Errors, FilterInput, dvl_message, filter_input
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

STATE_HZ = 50.0
FLOAT, STAMPED = "std_msgs/msg/Float64", "geometry_msgs/msg/TwistStamped"
ON_REQUEST = Delivery(on_request=True)


def twin_channels(source: Source, sim: Simulator, steering: Steering, *, per_thruster: bool) -> list[Channel]:
    """Return a vehicle's further channels. per_thruster: whether each thruster has topics of its own."""
    vehicle = source.of(sim)
    found = [_cmd_vel_stamped(source, steering)]
    for name, sensor in vehicle.sensors.items():
        for twin in _twins(sensor.kind, sim):
            delivery = Delivery(is_sampled=True, on_request=True)
            found.append(filter_input(source, name, sensor.rate_hz or DEFAULT_HZ, twin, delivery))
    if vehicle.thrusters:
        found.append(
            Channel(
                source.topic("thruster_states"), "sensor_msgs/msg/JointState", "out",
                "effort: the thrust of each thruster [N], which follows its command with a lag", rate_hz=STATE_HZ,
                over_link=OverLink(), delivery=ON_REQUEST, read=lambda sim: _thruster_states(source, sim),
            )
        )  # fmt: skip
        if per_thruster:
            found += _each_thruster(source, list(vehicle.thrusters), steering)
    return found


def _twins(kind: str, sim: Simulator) -> list[FilterInput]:
    pose, accel = "geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/AccelWithCovarianceStamped"
    every = {
        "usbl": FilterInput(
            "pose", pose, "position of the transponder in odom; no direction is measured",
            _usbl_pose(np.asarray(sim.scenario.station.position_m)), "odom",
        ),
        "imu": FilterInput(
            "accel", accel, "acceleration without gravity, by the IMU's own orientation",
            _acceleration(sim.world.water.gravity_m_s2),
        ),
        "dvl": FilterInput(
            "data", "dvl_msgs/msg/DVL", "as of Water Linked's driver; neither rssi nor nsd is modelled", _water_linked,
            even_invalid=True,
        ),
    }  # fmt: skip
    if sim.scenario.station.carrier is not None:
        del every["usbl"]  # its fixes are from a station that moves
    return [every[kind]] if kind in every else []


def _usbl_pose(station_m: Any) -> Callable[[Any, Any, Errors, Any], Any]:
    def write(value: Any, header: Any, errors: Errors, origin_m: Any) -> Any:
        line = np.asarray(value.position_m)
        along = np.outer(line, line) / (line @ line)
        across = np.eye(3) - along
        angle_m2 = errors.variance("bearing") * (line @ line)
        covariance = np.diag([UNOBSERVED] * 6)
        covariance[:3, :3] = errors.variance("range") * along + angle_m2 * across
        pose = build.pose(origin_m + station_m + line, build.IDENTITY_XYZW)
        return build.message(
            "geometry_msgs/msg/PoseWithCovarianceStamped",
            header=header,
            pose=build.message("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance.ravel()),
        )

    return write


def _acceleration(gravity_m_s2: float) -> Callable[[Any, Any, Errors, Any], Any]:
    """Return a writer of the specific force without its share of gravity; an error of the orientation turns it."""

    def write(value: Any, header: Any, errors: Errors, origin_m: Any) -> Any:
        x, y, z, w = value.orientation_xyzw
        up = quaternions.turned((-x, -y, -z, w), (0.0, 0.0, gravity_m_s2))
        variance = errors.variance("linear_acceleration") + gravity_m_s2**2 * errors.variance("orientation")
        covariance = np.diag([UNOBSERVED] * 6)
        covariance[:3, :3] = isotropic(variance).reshape(3, 3)
        accel = build.message("geometry_msgs/msg/Accel", linear=build.vector(value.linear_acceleration_m_s2 - up))
        return build.message(
            "geometry_msgs/msg/AccelWithCovarianceStamped",
            header=header,
            accel=build.message("geometry_msgs/msg/AccelWithCovariance", accel=accel, covariance=covariance.ravel()),
        )

    return write


def _water_linked(value: Any, header: Any, errors: Errors, origin_m: Any) -> Any:
    """Return a dvl_msgs/DVL: times in ms and us, axes as of dvl_link. fom: the mean standard deviation [m/s]."""
    dvl = dvl_message(value, header, errors)
    is_valid = dvl.velocity_covar[0] >= 0.0
    stamp_us = header.stamp.sec * 1_000_000 + header.stamp.nanosec // 1000
    beams = zip(value.beam_velocities_m_s, value.beam_ranges_m, dvl.beam_quality, strict=True)
    return build.message(
        "dvl_msgs/msg/DVL",
        header=header,
        time=1e3 / errors.rate_hz,
        velocity=dvl.velocity,
        fom=math.sqrt(dvl.velocity_covar[::4].mean()) if is_valid else math.nan,
        covariance=dvl.velocity_covar,
        altitude=dvl.altitude,
        beams=[
            build.message("dvl_msgs/msg/DVLBeam", id=k, velocity=float(speed), distance=float(far), valid=bool(good))
            for k, (speed, far, good) in enumerate(beams)
        ],
        velocity_valid=bool(is_valid),
        time_of_validity=stamp_us,
        time_of_transmission=stamp_us,
    )


def _cmd_vel_stamped(source: Source, steering: Steering) -> Channel:
    name, frames = "cmd_vel_stamped", ("", source.frame("base_link"), source.frame("base_footprint"))

    def apply(live: LiveSimulator, message: Any) -> None:
        if message.header.frame_id not in frames:
            raise ValueError(f"{name}: header.frame_id = '{message.header.frame_id}': must be '{frames[1]}'")
        stamp_ns = build.ns_of(message.header.stamp)
        late_s, limit_s = 1e-9 * (live.time_ns - stamp_ns), source.command_timeout_s(live.simulator)
        if stamp_ns and limit_s and abs(late_s) > limit_s:
            rule = f"must be within {limit_s:g} s of /clock (use_sim_time)"
            raise ValueError(f"{name}: header.stamp = {1e-9 * stamp_ns:.3f} s, {late_s:+.3f} s late: {rule}")
        steering.hold_velocity(live, six(name, message.twist.linear, message.twist.angular), name)

    return Channel(
        source.topic(name), STAMPED, "in", "as cmd_vel; refused if its stamp is older than the vehicle's timeout",
        frame_id=frames[1], over_link=OverLink(COMMAND), delivery=ON_REQUEST, apply=apply,
        authority=ended_by(build.message(STAMPED), apply),
    )  # fmt: skip


def _thruster_states(source: Source, sim: Simulator) -> Any:
    thrusters = source.of(sim).thrusters
    return build.message(
        "sensor_msgs/msg/JointState",
        header=build.header(sim.time_ns, ""),
        name=[source.topic(name) for name in thrusters],
        effort=np.array([each.thrust_n for each in thrusters.values()], np.float64),
    )


def _each_thruster(source: Source, names: list[str], steering: Steering) -> list[Channel]:
    """Return a command topic and a force topic for each thruster. A command leaves the other thrusters as they were."""
    topics = {name: source.topic(f"thrusters/{name}") for name in names}
    commands: dict[str, float] = {}

    def applier(name: str) -> Callable[[LiveSimulator, Any], None]:
        def apply(live: LiveSimulator, message: Any) -> None:
            THRUSTER.check_number(message.data, f"thrusters/{name}{ONE_THRUSTER}")
            held = {lease.name.removesuffix(ONE_THRUSTER) for lease in steering.shore.leases}
            if held.isdisjoint(topics.values()):
                commands.clear()  # another source has steered since
            commands[name] = message.data
            steering.give(live, "set_thrusters", commands=dict(commands))

        return apply

    def reader(name: str) -> Callable[[Simulator], Any]:
        return lambda sim: build.message(FLOAT, data=source.of(sim).thrusters[name].thrust_n)

    found = []
    for name, topic in topics.items():
        apply = applier(name)
        authority: Authority = ended_by(build.message(FLOAT), apply)
        found += [
            Channel(
                topic + ONE_THRUSTER, FLOAT, "in", "command in [-1, 1]", over_link=OverLink(COMMAND),
                delivery=ON_REQUEST, apply=apply, authority=authority,
            ),
            Channel(
                f"{topic}/force", FLOAT, "out", "thrust [N]", rate_hz=STATE_HZ, over_link=OverLink(),
                delivery=ON_REQUEST, read=reader(name),
            ),
        ]  # fmt: skip
    return found
