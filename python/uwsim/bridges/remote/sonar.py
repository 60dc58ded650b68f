"""The multibeam sonar of a remote vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.bridges.remote.connection import RemoteConnection
from uwsim.bridges.remote.frames import seconds
from uwsim.bridges.remote.tree import apart_s, matrix_of
from uwsim.channels.ros import build

FLOAT = "std_msgs/msg/Float64"
AIMED_RAD = 1e-4
"""The largest error at which a joint counts as having reached its target, since links round angles."""


@dataclass(frozen=True, eq=False)
class RemotePing:
    """A ping: ranges_m (beams,), inf for no echo; angles_rad (beams,); world_from_sonar (4, 4); time."""

    ranges_m: NDArray[np.float32]
    angles_rad: NDArray[np.float64]
    world_from_sonar: NDArray[np.float64]
    time_s: float

    @property
    def valid(self) -> NDArray[np.bool_]:
        """A mask (beams,) of the beams that have an echo."""
        return np.isfinite(self.ranges_m)

    @cached_property
    def points_sonar_m(self) -> NDArray[np.float32]:
        """The echo positions (beams, 3); NaN for no echo."""
        ranges = np.where(self.valid, self.ranges_m, np.nan).astype(np.float64)
        level = np.zeros_like(ranges)
        points = np.column_stack([ranges * np.cos(self.angles_rad), ranges * np.sin(self.angles_rad), level])
        points[~self.valid] = np.nan
        return points.astype(np.float32)


class RemoteSonar:
    """A multibeam read from a LaserScan topic and /tf, and turned by cmd_tilt."""

    name = "sonar"

    def __init__(
        self, connection: RemoteConnection, prefix: str, topic: str, odometry: str, origin_m: NDArray[np.float64]
    ) -> None:
        self._connection, self._prefix, self._topic = connection, prefix, topic
        self._odometry, self._origin_m = odometry, origin_m
        connection.subscribe("tf", keep=True)
        connection.newest("tf")
        connection.newest(topic)
        self._last: tuple[Any, RemotePing] | None = None
        self._target_rad: float | None = None

    def aim(self, elevation_rad: float) -> None:
        """Turn the head to an elevation, positive up. Raises ValueError or OSError."""
        if not abs(elevation_rad) <= 0.5 * math.pi:
            raise ValueError(f"elevation_rad = {elevation_rad} rad: must be in [-pi/2, pi/2]")
        self._connection.publish(f"{self._prefix}cmd_tilt", FLOAT, build.message(FLOAT, data=-float(elevation_rad)))
        self._target_rad = float(elevation_rad)

    @property
    def target_elevation_rad(self) -> float:
        """The elevation last passed to this object's `aim`, or the current one if there was no call."""
        return self.elevation_rad if self._target_rad is None else self._target_rad

    @property
    def is_aimed(self) -> bool:
        """True once the head has reached its target elevation."""
        return abs(self.elevation_rad - self.target_elevation_rad) <= AIMED_RAD

    @property
    def elevation_rad(self) -> float:
        """The head's current elevation."""
        joints = self._connection.newest(f"{self._prefix}joint_states")
        return -float(joints.position[list(joints.name).index(f"{self._prefix}sonar_tilt")])

    def ping(self) -> RemotePing:
        """Return the latest ping, with the head pose at its time. Raises ValueError or OSError."""
        scan = self._connection.newest(self._topic)
        if self._last is None or self._last[0] is not scan:
            ranges = np.asarray(scan.ranges, np.float32)
            ranges = np.where(np.isfinite(ranges) & (ranges <= scan.range_max), ranges, np.float32(np.inf))
            angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
            time_s = seconds(scan.header.stamp)
            self._last = scan, RemotePing(ranges, angles, self._world_from_sonar(time_s), time_s)
        return self._last[1]

    def _world_from_sonar(self, time_s: float) -> NDArray[np.float64]:
        nearest = min(self._connection.kept("tf"), key=lambda message: apart_s(message, time_s))
        frames = {transform.child_frame_id: transform.transform for transform in nearest.transforms}
        body, head = frames.get(f"{self._prefix}base_footprint"), frames.get(f"{self._prefix}base_scan")
        if body is None or head is None:
            raise ValueError("/tf: does not contain base_footprint and base_scan")
        world_from_sonar = matrix_of(body) @ matrix_of(head)
        world_from_sonar[:3, 3] += self._origin_m
        return world_from_sonar
