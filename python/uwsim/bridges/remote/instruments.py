"""Sensors, cameras and lamps of a remote vehicle."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from uwsim.base import lens_model
from uwsim.base.named import Named
from uwsim.base.short_repr import ShortRepr
from uwsim.bridges.remote.connection import RemoteConnection
from uwsim.bridges.remote.frames import quaternion, seconds, vector
from uwsim.bridges.remote.sonar import AIMED_RAD, FLOAT
from uwsim.bridges.remote.tree import RemoteTree
from uwsim.channels.ros import build
from uwsim.instruments.cameras.frame import MOUNT_FROM_OPTICAL

IMAGE = "/image_raw/compressed"
LEVELS = "/image"
LINK_FROM_SONAR = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""The rotation (3, 3) from sonar axes (x ahead, y to port, z up) to message axes (x up, y to starboard, z ahead)."""


def _imu(message: Any) -> SimpleNamespace:
    return SimpleNamespace(
        angular_velocity_rad_s=vector(message.angular_velocity),
        linear_acceleration_m_s2=vector(message.linear_acceleration),
        orientation_xyzw=quaternion(message.orientation),
    )


def _dvl(message: Any) -> SimpleNamespace:
    """Return the reading in sensor axes, converted from the message's axes (y to starboard, z down)."""
    return SimpleNamespace(
        velocity_m_s=vector(message.velocity) * (1.0, -1.0, -1.0),
        beam_ranges_m=np.asarray(message.range, np.float64),
        beam_velocities_m_s=np.asarray(message.beam_velocity, np.float64),
        bottom_lock=float(message.num_good_beams >= 3),
    )


def _fix(message: Any) -> SimpleNamespace:
    """Return latitude and longitude [deg], height [m] and whether there is a fix (1 or 0)."""
    return SimpleNamespace(
        latitude_deg=float(message.latitude), longitude_deg=float(message.longitude), height_m=float(message.altitude),
        fix=float(message.status.status >= 0),
    )  # fmt: skip


READERS: dict[str, Callable[[Any], Any]] = {
    "sensor_msgs/msg/Range": lambda message: float(message.range),
    "sensor_msgs/msg/FluidPressure": lambda message: float(message.fluid_pressure),
    "sensor_msgs/msg/Temperature": lambda message: float(message.temperature),
    "sensor_msgs/msg/Imu": _imu,
    "marine_acoustic_msgs/msg/Dvl": _dvl,
    "sensor_msgs/msg/NavSatFix": _fix,
    "geometry_msgs/msg/PointStamped": lambda message: SimpleNamespace(position_m=vector(message.point)),
    "std_msgs/msg/Float64": lambda message: float(message.data),
    "std_msgs/msg/Bool": lambda message: float(message.data),
}
"""Functions that convert messages to readings like those of uwsim.instruments.sensors.Sensor, by message type."""


class RemoteSensor:
    """A sensor whose readings arrive on a topic."""

    def __init__(self, connection: RemoteConnection, topic: str, value: Callable[[Any], Any]) -> None:
        self._connection, self._topic, self._value = connection, topic, value
        self.name = topic.rpartition("/")[2]

    def read(self) -> Any:
        """Return the latest reading; waits for the first one. Raises OSError."""
        return self._value(self._connection.newest(self._topic))


@dataclass(frozen=True, eq=False)
class RemoteLens:
    """A picture's intrinsics in pixels, as in sensor_msgs/CameraInfo: k (3, 3), d (see uwsim.base.lens_model)."""

    width: int
    height: int
    d: NDArray[np.float64]
    k: NDArray[np.float64]


class RemotePicture:
    """A JPEG picture. The intrinsics and pose are requested on first access."""

    def __init__(self, message: Any, lens: Callable[[], RemoteLens], pose: Callable[[], NDArray[np.float64]]) -> None:
        self.jpeg = bytes(message.data)
        self._lens, self._pose = lens, pose

    @cached_property
    def rgb(self) -> NDArray[np.uint8]:
        """The pixels, (height, width, 3)."""
        return np.asarray(Image.open(io.BytesIO(self.jpeg)).convert("RGB"))

    @cached_property
    def info(self) -> RemoteLens:
        """The intrinsics, from camera_info. Raises ValueError for no such topic or an unknown lens, or OSError."""
        return self._lens()

    @cached_property
    def world_from_camera(self) -> NDArray[np.float64]:
        """The camera's pose (4, 4), x ahead, y left, z up, from /tf at the picture's time.

        Raises ValueError or OSError.
        """
        return self._pose()


class RemoteCamera:
    """A camera whose compressed pictures arrive on topic start + IMAGE, to which `watch` subscribes."""

    def __init__(self, connection: RemoteConnection, start: str, tree: RemoteTree) -> None:
        self._connection, self._start, self._tree = connection, start, tree
        self._prefix, _, self.name = start.rpartition("camera/")
        self._target_rad: dict[str, float] = {}

    @property
    def aim_rad(self) -> tuple[float, float]:
        """The current pan (positive to port) and tilt (positive down) from joint_states, or 0 without a motor."""
        return self._joint_rad("pan"), self._joint_rad("tilt")

    @property
    def target_rad(self) -> tuple[float, float]:
        """The pan and tilt last passed to this object's `aim`, or the current angles if there was no call."""
        pan, tilt = self.aim_rad
        return self._target_rad.get("pan", pan), self._target_rad.get("tilt", tilt)

    @property
    def is_aimed(self) -> bool:
        """True once the camera has reached its target pan and tilt."""
        return all(abs(at - to) <= AIMED_RAD for at, to in zip(self.aim_rad, self.target_rad, strict=True))

    def aim(self, pan_rad: float | None = None, tilt_rad: float | None = None) -> None:
        """Turn towards these angles. None leaves an axis unchanged. Raises ValueError without a motor, or OSError."""
        wanted = {axis: rad for axis, rad in (("pan", pan_rad), ("tilt", tilt_rad)) if rad is not None}
        for axis in wanted:
            if f"{self._start}/cmd_{axis}" not in self._connection.topics:
                raise ValueError(f"camera '{self.name}': no motor: there is no topic '{self._start}/cmd_{axis}'")
        for axis, rad in wanted.items():
            self._connection.publish(f"{self._start}/cmd_{axis}", FLOAT, build.message(FLOAT, data=float(rad)))
            self._target_rad[axis] = float(rad)

    def _joint_rad(self, axis: str) -> float:
        topic, joint = f"{self._prefix}joint_states", f"{self._prefix}{self.name}_{axis}"
        joints = self._connection.newest(topic) if topic in self._connection.topics else None
        if joints is None or joint not in joints.name:
            return 0.0
        return float(joints.position[list(joints.name).index(joint)])

    def watch(self) -> RemoteCamera:
        """Subscribe before the first `capture`, since the first picture takes some simulated time to arrive."""
        self._connection.subscribe(self._start + IMAGE)
        return self

    def capture(self) -> RemotePicture:
        """Return the latest picture; waits for the first one. Raises OSError."""
        message = self._connection.newest(self._start + IMAGE)
        return RemotePicture(message, self._lens, partial(self._world_from_camera, message.header))

    def _lens(self) -> RemoteLens:
        info = self._connection.newest(f"{self._start}/camera_info")
        k = np.asarray(info.k, np.float64).reshape(3, 3)
        _, d = lens_model.coefficients(str(info.distortion_model), info.d)
        return RemoteLens(int(info.width), int(info.height), np.array(d), k)

    def _world_from_camera(self, header: Any) -> NDArray[np.float64]:
        world_from_camera = self._tree.world_from(str(header.frame_id), seconds(header.stamp))
        world_from_camera[:3, :3] = world_from_camera[:3, :3] @ MOUNT_FROM_OPTICAL.T
        return world_from_camera


@dataclass(frozen=True, eq=False, repr=False)
class RemoteSonarImage(ShortRepr):
    """The echo levels of an imaging sonar: level_db (bins, beams) dB re 1 uPa, bearings_rad (beams,), ranges_m (bins,).

    Bearings are about the sonar's z axis, positive to port. world_from_sonar: (4, 4), x ahead, y to port, z up.
    """

    level_db: NDArray[np.float32]
    bearings_rad: NDArray[np.float64]
    ranges_m: NDArray[np.float64]
    world_from_sonar: NDArray[np.float64]
    time_s: float


class RemoteImagingSonar:
    """An imaging sonar whose levels arrive on topic start + LEVELS."""

    def __init__(self, connection: RemoteConnection, start: str, tree: RemoteTree) -> None:
        self._connection, self._start, self._tree = connection, start, tree
        self.name = start.rpartition("/")[2]

    def ping(self, *arguments: Any, with_labels: bool = False) -> RemoteSonarImage:
        """Return the latest levels, waiting for the first if necessary.

        Raises ValueError for any argument, or OSError.
        """
        if arguments or with_labels:
            raise ValueError(f"imaging_sonars['{self.name}']: a remote sonar steers itself and has no labels")
        message = self._connection.newest(self._start + LEVELS)
        beams, ranges_m = int(message.image.beam_count), np.asarray(message.ranges, np.float64)
        levels = np.frombuffer(bytes(message.image.data), "<f4").reshape(len(ranges_m), beams)
        bearings = [np.arctan2(-beam.y, beam.z) for beam in message.beam_directions]
        time_s = seconds(message.header.stamp)
        world_from_link = self._tree.world_from(str(message.header.frame_id), time_s)
        world_from_link[:3, :3] = world_from_link[:3, :3] @ LINK_FROM_SONAR
        return RemoteSonarImage(levels.astype(np.float32), np.array(bearings), ranges_m, world_from_link, time_s)

    look = line = ping


class RemoteCameras(Named[RemoteCamera]):
    """Cameras, keyed by name. Looking up a camera subscribes to its pictures."""

    def __getitem__(self, name: str) -> RemoteCamera:
        return super().__getitem__(name).watch()


class RemoteLamp:
    """Lamps switched by a service."""

    def __init__(self, connection: RemoteConnection, service: str) -> None:
        self._connection, self._service, self._on = connection, service, False

    @property
    def on(self) -> bool:
        """Whether this object has switched the lamps on."""
        return self._on

    @on.setter
    def on(self, value: bool) -> None:
        self._connection.call(self._service, data=bool(value))
        self._on = bool(value)
