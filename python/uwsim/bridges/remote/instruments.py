"""Sensors, cameras and lamps of a remote vehicle."""

from __future__ import annotations

import io
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from PIL import Image

from uwsim.bridges.remote.connection import RemoteConnection
from uwsim.bridges.remote.frames import quaternion, vector


def _imu(message: Any) -> SimpleNamespace:
    return SimpleNamespace(
        angular_velocity_rad_s=vector(message.angular_velocity),
        linear_acceleration_m_s2=vector(message.linear_acceleration),
        orientation_xyzw=quaternion(message.orientation),
    )


def _dvl(message: Any) -> SimpleNamespace:
    """Return the reading in the sensor's axes: the message's y is to starboard and its z down."""
    return SimpleNamespace(
        velocity_m_s=vector(message.velocity) * (1.0, -1.0, -1.0),
        beam_ranges_m=np.asarray(message.range, np.float64),
        beam_velocities_m_s=np.asarray(message.beam_velocity, np.float64),
        bottom_lock=float(message.num_good_beams >= 3),
    )


READERS: dict[str, Callable[[Any], Any]] = {
    "sensor_msgs/msg/Range": lambda message: float(message.range),
    "sensor_msgs/msg/FluidPressure": lambda message: float(message.fluid_pressure),
    "sensor_msgs/msg/Temperature": lambda message: float(message.temperature),
    "sensor_msgs/msg/Imu": _imu,
    "marine_acoustic_msgs/msg/Dvl": _dvl,
    "geometry_msgs/msg/PointStamped": lambda message: SimpleNamespace(position_m=vector(message.point)),
    "std_msgs/msg/Float64": lambda message: float(message.data),
    "std_msgs/msg/Bool": lambda message: float(message.data),
}
"""How the message of each type that sensors have is read, into what uwsim.sensors.Sensor gives."""


class RemoteSensor:
    """A sensor behind a topic."""

    def __init__(self, connection: RemoteConnection, topic: str, value: Callable[[Any], Any]) -> None:
        self._connection, self._topic, self._value = connection, topic, value
        self.name = topic.rpartition("/")[2]

    def read(self) -> Any:
        """Return the newest reading; waits for the first. Raises OSError."""
        return self._value(self._connection.newest(self._topic))


class RemoteCamera:
    """A camera behind a topic of compressed pictures."""

    def __init__(self, connection: RemoteConnection, topic: str) -> None:
        self._connection, self._topic = connection, topic

    def capture(self) -> SimpleNamespace:
        """Return the newest picture: rgb (height, width, 3) uint8, jpeg; waits for the first. Raises OSError."""
        data = bytes(self._connection.newest(self._topic).data)
        return SimpleNamespace(rgb=np.asarray(Image.open(io.BytesIO(data)).convert("RGB")), jpeg=data)


class RemoteLamp:
    """Lamps behind a service."""

    def __init__(self, connection: RemoteConnection, service: str) -> None:
        self._connection, self._service, self._on = connection, service, False

    @property
    def on(self) -> bool:
        """Whether they were switched on from here."""
        return self._on

    @on.setter
    def on(self, value: bool) -> None:
        self._connection.call(self._service, data=bool(value))
        self._on = bool(value)
