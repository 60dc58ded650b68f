"""Publishes a vehicle's own estimate of its motion as nav_msgs/Odometry. The true motion is on `odom`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.channel import Channel, OverLink
from uwsim.channels.families.covariance import independent
from uwsim.channels.families.frames import Tf
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.navigation.estimation import Navigator
from uwsim.simulator.simulator import Simulator

RATE_HZ = 20.0
TOPIC = "odometry/estimate"
POSE_ERRORS = np.ix_([0, 1, 2, 6, 7, 8], [0, 1, 2, 6, 7, 8])  # of Navigator.covariance


def has_estimate(source: Source) -> bool:
    """Return whether a vehicle carries the instruments that onboard navigation needs."""
    return any(sensor.kind == "imu" for sensor in source.entry.model.sensors.values())


def estimate_channels(source: Source, tf: Tf = "truth") -> list[Channel]:
    """Return the channels of a vehicle's estimate. The list is empty for a vehicle without an IMU.

    It includes /odom if /tf carries the estimate.
    """
    if not has_estimate(source):
        return []
    return [
        Channel(
            source.topic(name), "nav_msgs/msg/Odometry", "out",
            "pose and velocity by the vehicle's own instruments, with covariances", rate_hz=RATE_HZ,
            frame_id=source.frame("odom"), over_link=OverLink(), read=lambda sim: _odometry(source, sim),
        )
        for name in (TOPIC, *(("odom",) if tf == "odom" else ()))
    ]  # fmt: skip


def _odometry(source: Source, sim: Simulator) -> Any:
    estimate = source.of(sim).navigation.shown
    pose, velocity = estimate.pose, estimate.velocity
    twist = build.message(
        "geometry_msgs/msg/Twist",
        linear=build.vector(velocity.linear_body_m_s),
        angular=build.vector(velocity.angular_body_rad_s),
    )
    stamp_ns = round(estimate.time_s * 1e9)
    pose_covariance, twist_covariance = covariances(estimate)
    return build.message(
        "nav_msgs/msg/Odometry",
        header=build.header(stamp_ns, source.frame("odom")),
        child_frame_id=source.frame("base_footprint"),
        pose=build.message(
            "geometry_msgs/msg/PoseWithCovariance",
            pose=build.pose(pose.position_world_m + source.origin_m, pose.orientation_xyzw),
            covariance=pose_covariance.ravel(),
        ),
        twist=build.message("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=twist_covariance.ravel()),
    )


def covariances(estimate: Navigator) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the pose and twist covariances, each (6, 6), as ROS defines them.

    Pose: position, then rotation about the fixed axes of odom. Twist: in body axes, so that the attitude error adds to
    the velocity error.
    """
    errors, turn = estimate.covariance, estimate.pose.world_from_body[:3, :3]
    x, y, z = estimate.velocity.linear_body_m_s.tolist()
    to_pose = np.eye(6)
    to_pose[3:, 3:] = turn
    pose = to_pose @ errors[POSE_ERRORS] @ to_pose.T
    to_twist = np.zeros((6, 9))
    to_twist[:3, :3], to_twist[:3, 3:6] = turn.T, [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    to_twist[3:, 6:] = -np.eye(3)
    twist = to_twist @ errors[3:12, 3:12] @ to_twist.T
    return pose, twist + independent(0.0, 0.0, 0.0, *[estimate.rate_std_rad_s**2] * 3).reshape(6, 6)
