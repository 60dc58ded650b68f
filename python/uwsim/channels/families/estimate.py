"""Publishes a vehicle's own estimate of its motion as nav_msgs/Odometry. The true motion is on `odom`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.channel import Channel, OverLink
from uwsim.channels.families.frames import Tf
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.channels.taped import Make, Stretch, Taped
from uwsim.navigation.estimation import Navigator
from uwsim.simulator.simulator import Simulator

RATE_HZ = 20.0
TOPIC = "odometry/estimate"
POSITIONS, RATES = np.arange(3), np.arange(3, 6)  # the first and last three of a pose or twist
POSE_ERRORS = np.array([0, 1, 2, 6, 7, 8])  # of Navigator.covariance


def has_estimate(source: Source) -> bool:
    """Return whether a vehicle carries the instruments that onboard navigation needs."""
    return any(sensor.kind == "imu" for sensor in source.entry.model.sensors.values())


def estimate_channels(source: Source, tf: Tf = "truth") -> list[Channel]:
    """Return the channels of a vehicle's estimate. The list is empty for a vehicle without an IMU.

    It includes /odom if /tf carries the estimate.
    """
    if not has_estimate(source):
        return []

    def begin(sim: Simulator) -> Make:
        rate_variance = _shown(source, sim).rate_std_rad_s ** 2
        return lambda rows: Stretch(rows[0].times_ns, _odometry(source, rows[0].values, rate_variance))

    def read(sim: Simulator) -> Any:
        estimate = _shown(source, sim)
        return _odometry(source, estimate.numbers, estimate.rate_std_rad_s**2)

    taped = Taped((), begin, note=lambda sim: _shown(source, sim).numbers)
    return [
        Channel(
            source.topic(name), "nav_msgs/msg/Odometry", "out",
            "pose and velocity by the vehicle's own instruments, with covariances", rate_hz=RATE_HZ,
            frame_id=source.frame("odom"), over_link=OverLink(),
            read=read, taped=taped,
        )
        for name in (TOPIC, *(("odom",) if tf == "odom" else ()))
    ]  # fmt: skip


def _shown(source: Source, sim: Simulator) -> Navigator:
    return source.of(sim).navigation.shown


def _odometry(source: Source, noted: NDArray[np.float64], rate_variance: float) -> Any:
    """Return the message of `Navigator.numbers`, or that of columns for n rows of them."""
    position_m, orientation_xyzw, linear_m_s = noted[..., 1:4], noted[..., 4:8], noted[..., 8:11]
    rows = noted.shape[:-1]
    twist = build.message(
        "geometry_msgs/msg/Twist", linear=build.vector(linear_m_s), angular=build.vector(noted[..., 11:14])
    )
    pose_covariance, twist_covariance = covariances(
        noted[..., 23:].reshape(*rows, 15, 15), noted[..., 14:23].reshape(*rows, 3, 3), linear_m_s, rate_variance
    )
    stamp_ns = np.rint(noted[..., 0] * 1e9).astype(np.uint64)
    return build.message(
        "nav_msgs/msg/Odometry",
        header=build.header(stamp_ns, source.frame("odom")),
        child_frame_id=source.frame("base_footprint"),
        pose=build.message(
            "geometry_msgs/msg/PoseWithCovariance",
            pose=build.pose(position_m + source.origin_m, orientation_xyzw),
            covariance=pose_covariance.reshape(*rows, 36),
        ),
        twist=build.message(
            "geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=twist_covariance.reshape(*rows, 36)
        ),
    )


def covariances(
    errors: NDArray[np.float64], turn: NDArray[np.float64], linear_m_s: NDArray[np.float64], rate_variance: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the pose and twist covariances, each (6, 6), as ROS defines them, or (n, 6, 6) for n estimates.

    Pose: position, then rotation about the fixed axes of odom. Twist: in body axes, so that the attitude error adds to
    the velocity error. errors: (15, 15), see Navigator. turn: world from body, (3, 3). linear_m_s: (3,).
    rate_variance: of the white noise in the rates [rad2/s2].
    """
    rows = errors.shape[:-2]
    x, y, z = linear_m_s.T
    to_pose = np.zeros((*rows, 6, 6))
    to_pose[..., POSITIONS, POSITIONS] = 1.0
    to_pose[..., 3:, 3:] = turn
    pose = to_pose @ errors[..., POSE_ERRORS[:, None], POSE_ERRORS] @ np.swapaxes(to_pose, -1, -2)
    to_twist = np.zeros((*rows, 6, 9))
    to_twist[..., :3, :3] = np.swapaxes(turn, -1, -2)
    to_twist[..., 0, 4], to_twist[..., 0, 5], to_twist[..., 1, 5] = -z, y, -x
    to_twist[..., 1, 3], to_twist[..., 2, 3], to_twist[..., 2, 4] = z, -y, x
    to_twist[..., 3:, 6:] = -np.eye(3)
    twist = to_twist @ errors[..., 3:12, 3:12] @ np.swapaxes(to_twist, -1, -2)
    white = np.zeros((*rows, 6, 6))
    white[..., RATES, RATES] = rate_variance
    return pose, twist + white
