"""RemoteVehicle: a vehicle accessed through topics, with the same interface for missions as a simulated vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.axes import AXES
from uwsim.base.commands import Commandable, command_named
from uwsim.base.motion import Pose, Velocity
from uwsim.base.named import Named
from uwsim.bridges.remote.connection import RemoteConnection
from uwsim.bridges.remote.frames import matrix, quaternion, vector
from uwsim.bridges.remote.instruments import (
    IMAGE,
    LEVELS,
    READERS,
    RemoteCamera,
    RemoteCameras,
    RemoteImagingSonar,
    RemoteLamp,
    RemoteSensor,
)
from uwsim.bridges.remote.sonar import RemoteSonar
from uwsim.bridges.remote.tree import RemoteTree
from uwsim.channels.calls.command_services import request_of
from uwsim.channels.families.key import POSE, key_message
from uwsim.channels.ros.own_types import ALL_STOPPED
from uwsim.instruments.gauges import GAUGES

LIGHT_SERVICE = "lights/"
GAUGE_NAMES = {gauge.attribute: gauge.name for gauge in GAUGES}
PROJECTED = "marine_acoustic_msgs/msg/ProjectedSonarImage"


@dataclass(frozen=True)
class RemotePanel:
    """A remote vehicle's panel; values that it does not report are NaN."""

    battery_percent: float
    depth_m: float = math.nan
    distance_to_seabed_m: float = math.nan
    distance_to_station_m: float = math.nan
    speed_m_s: float = math.nan
    range_warning: bool = False
    proximity_warning: bool = False
    collision_warning: bool = False


class RemoteVehicle(Commandable):
    """A vehicle behind a rosbridge server. It uses odometry for motion, services for commands, topic `key` for efforts.

    name: the vehicle's name, if there are several vehicles. odometry: the topic with its pose; a simulator's "odom" is
    the truth. Topics are subscribed to when first read. Raises ValueError if there is no such vehicle, or OSError.
    """

    def __init__(self, connection: RemoteConnection, name: str | None = None, odometry: str = "odom") -> None:
        self._connection, self._tree = connection, RemoteTree(connection)
        self._prefix = _prefix(connection, name)
        self.name = name or self._prefix.rstrip("/") or "rov"
        self._odometry = self._prefix + odometry
        for topic in (self._odometry, f"{self._prefix}key"):
            if topic not in connection.topics:
                raise ValueError(f"{connection.url}: there is no topic '{topic}'")
        connection.newest(self._odometry)
        self._last: tuple[Any, Pose, Velocity] | None = None

    @property
    def beacon(self) -> str:
        """The topic whose time stamps give the times of the vehicle's readings."""
        return self._odometry

    @property
    def pose(self) -> Pose:
        """The latest pose."""
        return self._motion()[1]

    @property
    def velocity(self) -> Velocity:
        """The latest velocity, in body axes."""
        return self._motion()[2]

    def _motion(self) -> tuple[Any, Pose, Velocity]:
        message = self._connection.newest(self._odometry)
        if self._last is None or self._last[0] is not message:
            twist = message.twist.twist
            pose = pose_of(message.pose.pose, self._world_from_odom_m)
            self._last = message, pose, Velocity(vector(twist.linear), vector(twist.angular))
        return self._last

    @cached_property
    def _world_from_odom_m(self) -> NDArray[np.float64]:
        """The origin of odom in the world, (3,), from /tf_static, or zero if /tf_static does not contain it."""
        if "tf_static" not in self._connection.topics:
            return np.zeros(3)
        above = {each.child_frame_id: each for each in self._connection.newest("tf_static").transforms}
        origin_m, at = np.zeros(3), f"{self._prefix}odom"
        for _ in range(len(above)):  # world -> map -> odom, or world -> odom
            if at in above:
                origin_m = origin_m + vector(above[at].transform.translation)
                at = above[at].header.frame_id
        return origin_m if at == "world" else np.zeros(3)

    @cached_property
    def sensors(self) -> Named[RemoteSensor]:
        """The sensors, keyed by name: all topics with a sensor message type."""
        found = {}
        for topic, kind in self._connection.topics.items():
            name = topic.removeprefix(self._prefix)
            if topic.startswith(self._prefix) and "/" not in name and kind in READERS:
                found[name] = RemoteSensor(self._connection, topic, READERS[kind])
        return Named(found, f"{self.name}.sensors")

    @cached_property
    def sonar(self) -> RemoteSonar:
        """The multibeam. Raises ValueError if there is none."""
        if not (topic := self._sonar_topic()):
            raise ValueError(f"vehicle '{self.name}': carries no sonar")
        return RemoteSonar(self._connection, self._prefix, topic, self._odometry, self._world_from_odom_m)

    def _sonar_topic(self) -> str | None:
        names = [f"{self._prefix}{name}" for name in ("ping", "scan")]
        return next((name for name in names if name in self._connection.topics), None)

    @property
    def sonars(self) -> Named[RemoteSonar]:
        """The multibeams, keyed by name."""
        return Named({"sonar": self.sonar} if self._sonar_topic() else {}, f"{self.name}.sonars")

    @cached_property
    def imaging_sonars(self) -> Named[RemoteImagingSonar]:
        """The imaging sonars, keyed by name: all topics with their levels."""
        found = {}
        for topic, kind in self._connection.topics.items():
            name = topic.removeprefix(self._prefix).removesuffix(LEVELS)
            if topic == f"{self._prefix}{name}{LEVELS}" and "/" not in name and kind == PROJECTED:
                found[name] = RemoteImagingSonar(self._connection, self._prefix + name, self._tree)
        return Named(found, f"{self.name}.imaging_sonars")

    @cached_property
    def cameras(self) -> RemoteCameras:
        """The cameras, keyed by name."""
        start = f"{self._prefix}camera/"
        names = [
            topic.removeprefix(start).removesuffix(IMAGE)
            for topic in self._connection.topics
            if topic.startswith(start) and topic.endswith(IMAGE)
        ]
        cameras = {name: RemoteCamera(self._connection, f"{start}{name}", self._tree) for name in names}
        return RemoteCameras(cameras, f"{self.name}.cameras")

    @cached_property
    def lamps(self) -> Named[RemoteLamp]:
        """The lamps, keyed by name."""
        start = f"{self._prefix}{LIGHT_SERVICE}"
        services = [str(name).lstrip("/") for name in self._connection.call("rosapi/services").get("services", [])]
        names = [name.removeprefix(start) for name in services if name.startswith(start)]
        return Named({name: RemoteLamp(self._connection, start + name) for name in names}, f"{self.name}.lamps")

    @property
    def released(self) -> bool:
        """Whether the vehicle has left the station, or True if the vehicle does not report this."""
        panel = self._telemetry()
        return True if panel is None else bool(panel.released)

    @property
    def all_stopped(self) -> bool:
        """Whether all stop is set, or False if the vehicle does not report this."""
        panel = self._telemetry()
        return panel is not None and ALL_STOPPED in panel.alarms

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Issue a command of uwsim.base.commands: efforts on topic `key`, all others by services.

        Raises ValueError or OSError. Efforts are not acknowledged. Other commands have taken effect, or been sent over
        a link, by the time this returns.
        """
        command = command_named(name)
        command.named(self.name, arguments)
        if name == "set_effort":
            message = key_message({axis: arguments.get(axis, 0.0) for axis in AXES})
            self._connection.publish(f"{self._prefix}key", POSE, message)
        elif command.service:
            self._connection.call(self._prefix + name, **request_of(command, arguments))
        else:
            raise ValueError(f"vehicle '{self.name}': {name}: not available over rosbridge: the command has no service")

    def telemetry(self) -> RemotePanel:
        """Return the panel from /telemetry or, without that topic, only the battery."""
        panel = self._telemetry()
        if panel is not None:
            names = [each.name for each in fields(RemotePanel)]
            return RemotePanel(**{name: getattr(panel, GAUGE_NAMES.get(name, name)) for name in names})
        battery = f"{self._prefix}battery_state"
        if battery not in self._connection.topics:
            return RemotePanel(math.nan)
        return RemotePanel(100.0 * float(self._connection.newest(battery).percentage))

    def _telemetry(self) -> Any:
        topic = f"{self._prefix}telemetry"
        return self._connection.newest(topic) if topic in self._connection.topics else None


def pose_of(message: Any, origin_m: NDArray[np.float64]) -> Pose:
    """Convert a geometry_msgs/Pose to a Pose, shifted by origin_m (3,)."""
    position_m, turn = vector(message.position) + origin_m, quaternion(message.orientation)
    return Pose(position_m, turn, matrix(position_m, turn))


def vehicle_names(connection: RemoteConnection) -> list[str]:
    """Return the names of a server's vehicles, or an empty list for a single vehicle whose topics have no prefix."""
    return sorted(topic.removesuffix("/key") for topic in connection.topics if topic.endswith("/key"))


def _prefix(connection: RemoteConnection, name: str | None) -> str:
    """Return the prefix of a vehicle's topics. Raises ValueError."""
    vehicles = vehicle_names(connection)
    if name is None:
        if "key" in connection.topics:
            return ""
        if not vehicles:
            raise ValueError(f"{connection.url}: there is no topic 'key' for commanding a vehicle")
        return f"{vehicles[0]}/"
    if name in vehicles:
        return f"{name}/"
    if not vehicles and "key" in connection.topics:
        return ""
    raise ValueError(f"{connection.url}: vehicle = {name!r}: must be one of {', '.join(vehicles) or 'none'}")
