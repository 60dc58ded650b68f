"""The messages of sensors that state where they are: a GPS and an INS."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from uwsim.base.quaternions import matrix
from uwsim.channels.families.covariance import UNKNOWN
from uwsim.channels.ros import build
from uwsim.mapping.files.georeference import Georeference

NO_FIX, FIX, BY_GPS, DIAGONAL_KNOWN = -1, 0, 1, 2  # of NavSatStatus and NavSatFix


class PositionErrors(Protocol):
    """A sensor's error statistics, the world's place on Earth and the name of the sensor's frame."""

    @property
    def frame_id(self) -> str:
        """The sensor's own frame."""

    @property
    def place(self) -> Georeference:
        """The place of the world."""

    def variance(self, channel: str, /) -> float:
        """Return the error variance of a channel [unit^2]."""


def nav_sat_fix(value: Any, header: Any, errors: PositionErrors) -> Any:
    """Return a NavSatFix; without a fix, its status is -1 and its numbers are NaN."""
    has_fix = bool(value.fix)
    latitude_deg, longitude_deg = errors.place.degrees(value.position_m) if has_fix else (math.nan, math.nan)
    horizontal, vertical = errors.variance("horizontal"), errors.variance("vertical")
    return build.message(
        "sensor_msgs/msg/NavSatFix",
        header=header,
        status=build.message("sensor_msgs/msg/NavSatStatus", status=FIX if has_fix else NO_FIX, service=BY_GPS),
        latitude=float(latitude_deg),
        longitude=float(longitude_deg),
        altitude=float(value.position_m[2]),
        position_covariance=np.diag([horizontal, horizontal, vertical]).ravel(),
        position_covariance_type=DIAGONAL_KNOWN if has_fix else 0,
    )


def ins_odometry(value: Any, header: Any, errors: PositionErrors, origin_m: Any) -> Any:
    """Return an Odometry of the sensor's frame, whose covariances are unknown."""
    unknown = np.array([UNKNOWN, *[0.0] * 35])
    pose = build.pose(value.position_m + origin_m, value.orientation_xyzw)
    velocity = matrix(value.orientation_xyzw).T @ value.velocity_m_s
    twist = build.message("geometry_msgs/msg/Twist", linear=build.vector(velocity))
    return build.message(
        "nav_msgs/msg/Odometry",
        header=header,
        child_frame_id=errors.frame_id,
        pose=build.message("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=unknown),
        twist=build.message("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=unknown),
    )
