"""Channels for time, frames and motion: /clock, /tf, /tf_static, odometry and joint states.

The user chooses the source of odom -> base_link on /tf; see `Tf`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.channels.channel import LATCHED, Channel, Delivery, OverLink
from uwsim.channels.families.body_frames import SONAR_TILT, body_frames
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.channels.taped import Motion, Stretch, Taped, Track, of_motion, of_motions
from uwsim.instruments.cameras import Camera
from uwsim.simulator.arm import Arm
from uwsim.simulator.simulator import Simulator

Tf = Literal["truth", "odom", "none"]
"""The motion on /tf and /odom: the true motion, the vehicle's estimate, or none, so that other nodes may publish it."""
RATE_HZ = 50.0
CLOCK_HZ = 100.0
Transform = tuple[str, str, ArrayLike, ArrayLike]
"""Parent, child, position and orientation in the parent."""


def clock_channel() -> Channel:
    """Return the channel /clock."""
    return Channel(
        "clock", "rosgraph_msgs/msg/Clock", "out", "simulated time", rate_hz=CLOCK_HZ, delivery=Delivery(leads=True),
        read=lambda sim: _clock(sim.time_ns),
        taped=Taped((Track(),), lambda sim: lambda rows: Stretch(rows[0].times_ns, _clock(rows[0].times_ns))),
    )  # fmt: skip


def _clock(time_ns: Any) -> Any:
    return build.message("rosgraph_msgs/msg/Clock", clock=build.time(time_ns))


def common_channels(
    sources: Sequence[Source],
    tf: Tf = "truth",
    prefix: str = "",
    *,
    rate_hz: float = RATE_HZ,
    joint_frames: bool = False,
) -> list[Channel]:
    """Return the channels that all vehicles share. prefix: the prefix of frames that do not belong to a vehicle.

    rate_hz: the rate of /tf. joint_frames: whether the frames that only the URDF has are published, too, as
    robot_state_publisher would: cameras' pan and tilt, thrusters, fins.
    """
    moving = partial(_moving, sources, tf, prefix, joint_frames)
    return [
        clock_channel(),
        Channel(
            "tf", "tf2_msgs/msg/TFMessage", "out", "moving frames: vehicles, sonar heads, cameras that turn or follow",
            rate_hz=rate_hz, delivery=Delivery(leads=True), over_link=OverLink(),
            read=lambda sim: moving(sim)([Motion.now(source, sim) for source in sources]),
            taped=of_motions(sources, lambda sim: moving(sim) if _follows(sources, tf, joint_frames, sim) else None),
        ),
        Channel(
            "tf_static", "tf2_msgs/msg/TFMessage", "out", "fixed frames: world -> map -> odom, sensors, cameras",
            delivery=LATCHED, read=lambda sim: _fixed(sources, tf, prefix, joint_frames, sim),
        ),
    ]  # fmt: skip


def vehicle_channels(source: Source, tf: Tf = "truth", *, truth: bool = True) -> list[Channel]:
    """Return a vehicle's joint-state channel and, if the truth may be published, the channels of its true motion."""
    found = [
        Channel(
            source.topic(name), "nav_msgs/msg/Odometry", "out", "the true pose and velocity; covariances are 0",
            rate_hz=RATE_HZ, frame_id=source.frame("odom"), over_link=OverLink(packing=packing),
            **of_motion(source, lambda motion: _odometry(source, motion)),
        )
        for name, packing in (("ground_truth/odom", ""), *((("odom", "deflate"),) if tf == "truth" else ()))
        if truth
    ]  # fmt: skip
    turning = any(camera.pan_tilt is not None for camera in source.entry.model.cameras.values())
    if source.has_sonar or source.entry.model.fins or turning or source.entry.model.arm:
        found.append(
            Channel(
                source.topic("joint_states"), "sensor_msgs/msg/JointState", "out",
                "angles [rad]: sonar_tilt (positive: nose down), cameras' pan and tilt, fins; an arm's joints, with "
                "speed and motor torque",
                rate_hz=RATE_HZ, over_link=OverLink(),
                read=lambda sim: _joints(source, _angles(source, sim), Motion.now(source, sim), source.of(sim).arm),
                taped=of_motions([source], lambda sim: _joints_at_rest(source, sim)),
            )
        )  # fmt: skip
    return found


def _odometry(source: Source, motion: Motion) -> Any:
    twist = build.message(
        "geometry_msgs/msg/Twist", linear=build.vector(motion.linear_m_s), angular=build.vector(motion.angular_rad_s)
    )
    pose = build.pose(motion.position_m + source.origin_m, motion.orientation_xyzw)
    return build.message(
        "nav_msgs/msg/Odometry",
        header=build.header(motion.time_ns, source.frame("odom")),
        child_frame_id=source.frame("base_footprint"),
        pose=build.message("geometry_msgs/msg/PoseWithCovariance", pose=pose),
        twist=build.message("geometry_msgs/msg/TwistWithCovariance", twist=twist),
    )


def _angles(source: Source, sim: Simulator) -> dict[str, Any]:
    """Return the angle [rad] of each joint by name."""
    vehicle = source.of(sim)
    angles = {SONAR_TILT: -vehicle.sonar.elevation_rad} if source.has_sonar else {}
    for name, camera in vehicle.cameras.items():
        if camera.mount.pan_tilt is not None:
            angles |= dict(zip((f"{name}_pan", f"{name}_tilt"), camera.aim_rad, strict=True))
    arm = {} if vehicle.arm is None else dict(zip(vehicle.arm.names, vehicle.arm.read().positions, strict=True))
    return angles | vehicle.fins | arm


def _joints(source: Source, angles: dict[str, Any], motion: Motion, arm: Arm | None) -> Any:
    more: dict[str, NDArray[np.float64]] = {}
    if arm is not None:  # the others have neither; the message has all values or none
        now, others = arm.measure(), np.full(len(angles) - len(arm.names), np.nan)
        angles |= dict(zip(now.names, now.positions, strict=True))
        more["velocity"] = np.concatenate([others, now.speeds])
        more["effort"] = np.concatenate([others, now.motor_torques])
    return build.message(
        "sensor_msgs/msg/JointState",
        header=build.header(motion.time_ns, ""),
        name=[source.topic(name) for name in angles],
        position=np.stack(np.broadcast_arrays(*angles.values()), axis=-1).astype(np.float64),
        **more,
    )


def _joints_at_rest(source: Source, sim: Simulator) -> Callable[[Sequence[Motion]], Any] | None:
    """Return what makes the joint states if only the multibeam's head turns; otherwise None."""
    vehicle, angles = source.of(sim), _angles(source, sim)
    if vehicle.arm is not None or vehicle.fins or not all(camera.is_aimed for camera in vehicle.cameras.values()):
        return None
    head = [SONAR_TILT] if source.has_sonar else []
    return lambda motions: _joints(source, angles | dict.fromkeys(head, -motions[0].elevation_rad), motions[0], None)


def _follows(sources: Sequence[Source], tf: Tf, joint_frames: bool, sim: Simulator) -> bool:
    """Return whether all that moves on /tf follows from the vehicles' true motion."""
    cameras = [camera for source in sources for camera in source.of(sim).cameras.values()] + [*sim.cameras.values()]
    return tf != "odom" and not joint_frames and all(camera.is_aimed for camera in cameras)


def _moving(
    sources: Sequence[Source], tf: Tf, prefix: str, joint_frames: bool, sim: Simulator
) -> Callable[[Sequence[Motion]], Any]:
    """Return the function that makes the message of /tf from the motion of all vehicles."""
    writers = [_moving_on(source, tf, joint_frames, sim) for source in sources]
    station = [
        _optical(prefix + "station", prefix + name, camera)
        for name, camera in sim.cameras.items()
        if camera.mount.pan_tilt
    ]

    def write(motions: Sequence[Motion]) -> Any:
        own = [each for write, motion in zip(writers, motions, strict=True) for each in write(motion)]
        others = [build.transform(motions[0].time_ns, *each) for each in station]
        return build.message("tf2_msgs/msg/TFMessage", transforms=own + others)

    return write


def _moving_on(source: Source, tf: Tf, joint_frames: bool, sim: Simulator) -> Callable[[Motion], list[Any]]:
    """Return the function that makes a vehicle's transforms from its motion."""
    vehicle, frame = source.of(sim), source.frame
    cameras: list[Callable[[Motion], Transform]] = []
    for name, camera in vehicle.cameras.items():
        if camera.mount.follows == "heading":
            cameras.append(partial(_following, frame(f"{name}_optical"), camera))
        elif camera.mount.pan_tilt is not None and not joint_frames:
            cameras.append(partial(_constant, _optical(frame("base_link"), frame(name), camera)))

    def write(motion: Motion) -> list[Any]:
        found = []
        if tf == "truth":
            pose = motion.position_m + source.origin_m, motion.orientation_xyzw
            found.append(build.transform(motion.time_ns, frame("odom"), frame("base_footprint"), *pose))
        elif tf == "odom":
            estimate = vehicle.navigation.shown
            pose = estimate.pose.position_world_m + source.origin_m, estimate.pose.orientation_xyzw
            stamp_ns = round(1e9 * estimate.time_s)
            found.append(build.transform(stamp_ns, frame("odom"), frame("base_link"), *pose))
        if source.has_sonar:
            tilt = source.scan_mount_m, motion.tilt_xyzw
            found.append(build.transform(motion.time_ns, frame("base_link"), frame("base_scan"), *tilt))
        found += [build.transform(motion.time_ns, *place(motion)) for place in cameras]
        return found + (_turning(source, sim) if joint_frames else [])

    return write


def _constant(transform: Transform, motion: Motion) -> Transform:
    return transform


def _turning(source: Source, sim: Simulator) -> list[Any]:
    """Return the transforms of the joints that are on /tf on request only."""
    angles = _angles(source, sim)
    return [
        build.transform(
            sim.time_ns, source.frame(one.parent), source.frame(one.name), one.moved_m(angles[one.joint.name]),
            one.turned_xyzw(angles[one.joint.name]),
        )
        for one in body_frames(source.entry.model)
        if one.joint is not None and one.is_described_only
    ]  # fmt: skip


def _fixed(sources: Sequence[Source], tf: Tf, prefix: str, joint_frames: bool, sim: Simulator) -> Any:
    station = sim.scenario.station
    yaw_xyzw = of_yaw_pitch_roll_deg((station.yaw_deg, 0.0, 0.0))
    carriers = [source for source in sources if source.name == station.carrier]
    parent = carriers[0].frame("base_link") if carriers else "world"
    transforms = [build.transform(sim.time_ns, parent, prefix + "station", station.position_m, yaw_xyzw)]
    transforms += [
        build.transform(sim.time_ns, *_optical(prefix + "station", prefix + name, camera))
        for name, camera in sim.cameras.items()
        if not camera.mount.pan_tilt
    ]
    transforms.append(build.transform(sim.time_ns, "world", prefix + "map", -sources[0].origin_m))
    for source in sources:
        frame = source.frame
        # A frame has only one parent: if another node publishes odom -> base_link, base_footprint is below base_link.
        parent, child = ("base_footprint", "base_link") if tf == "truth" else ("base_link", "base_footprint")
        transforms.append(build.transform(sim.time_ns, frame(parent), frame(child), (0.0, 0.0, 0.0)))
        if tf != "none":
            transforms.append(build.transform(sim.time_ns, prefix + "map", frame("odom"), (0.0, 0.0, 0.0)))
        transforms += [
            build.transform(sim.time_ns, frame(one.parent), frame(one.name), one.position_m, one.orientation_xyzw)
            for one in body_frames(source.entry.model)
            if one.joint is None and (joint_frames or not one.is_described_only)
        ]
    return build.message("tf2_msgs/msg/TFMessage", transforms=transforms)


def _following(child: str, camera: Camera, motion: Motion) -> Transform:
    position_m, orientation_xyzw = camera.carried(motion.position_m, motion.orientation_xyzw)
    return "world", child, position_m, build.turned_xyzw(orientation_xyzw, build.OPTICAL_XYZW)


def _optical(parent: str, name: str, camera: Camera) -> Transform:
    turn = build.turned_xyzw(camera.mounting_xyzw(), build.OPTICAL_XYZW)
    return parent, f"{name}_optical", camera.mount.position_m, turn
