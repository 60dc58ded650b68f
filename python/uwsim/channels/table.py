"""The table of all channels and services of a simulator. A family of channels is an entry point, see `registered`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.authority.rights import Rights
from uwsim.channels.authority.steering import Steering, is_cut_off
from uwsim.channels.calls.command_services import push_service
from uwsim.channels.calls.parameters import parameter_services
from uwsim.channels.calls.services import simulation_services, stream_service
from uwsim.channels.channel import Channel, Service
from uwsim.channels.delivery.pictures import Pictures
from uwsim.channels.families import frames
from uwsim.channels.families.cameras import station_cameras
from uwsim.channels.families.estimate import has_estimate
from uwsim.channels.families.frames import Tf
from uwsim.channels.families.map import PingMap
from uwsim.channels.families.pings import Pings
from uwsim.channels.families.published import TRUE_TOPICS, published_channels, station_picture
from uwsim.channels.families.registered import items_of, logged_channels
from uwsim.channels.families.tether import object_tether_channels
from uwsim.channels.source import Source
from uwsim.simulator.helm import Helm
from uwsim.simulator.simulator import Simulator

Wire = Literal["standard", "published", "both"]
ORIGINS: dict[str, tuple[float, float, float]] = {"world": (0.0, 0.0, 0.0), "published": (0.0, 0.0, 75.3)}
"""The world's origin in odom, by name. published: the published simulator's water surface is at z = 75.3 m."""


class Table:
    """The channels and services of one simulator, which share its latest pings, pictures and maps.

    Created once by the server, recorder or replay, and passed to everything that needs part of it. wire: "published"
    selects the topics of the paper's simulator, "standard" the usual ROS topics. origin: the world's origin in the odom
    frame, (3,) [m], or a name in ORIGINS. With several vehicles, topics and frames are prefixed by their names. tf: the
    motion on /tf and /odom, see `frames.Tf`; the truth is on /ground_truth/odom in any case. frame_prefix: prefix of
    all frames except world, such as "auv/". may_wait: whether the steps may wait for pictures; if not, late pictures
    are skipped. is_behind: see Pictures. truth: whether the true motion is published, on /telemetry,
    /ground_truth/odom, /odom, /tf and the paper's /propPos and /stateData. If it is not, /odom and /tf carry the
    estimate, and the true motion is omitted elsewhere. tf_rate_hz: the rate of /tf. joint_frames: whether /tf and
    /tf_static also have the frames that otherwise only the URDF has. thruster_topics: whether each thruster also has a
    command topic of its own. Raises ValueError.

    published: the names of the topics of the paper's simulator. has_standard: whether it also has the usual ones.
    channels, services: the channels and services visible to clients. Links and recorders replace them with those that
    they carry or record.
    """

    def __init__(
        self,
        sim: Simulator,
        *,
        wire: Wire = "both",
        origin: str | Sequence[float] = "world",
        may_wait: Callable[[], bool] = lambda: True,
        is_behind: Callable[[], bool] = lambda: False,
        truth: bool = True,
        tf: Tf = "truth",
        frame_prefix: str = "",
        tf_rate_hz: float = frames.RATE_HZ,
        joint_frames: bool = False,
        thruster_topics: bool = False,
    ) -> None:
        self.truth = truth
        self.tf_rate_hz, self.joint_frames = checked_rate(sim, tf_rate_hz), joint_frames
        self._thruster_topics = thruster_topics
        self.frame_prefix = frame_prefix
        self.origin_m = checked_wire(wire, origin)
        self.sources = Source.all_of(sim.scenario, self.origin_m, frame_prefix)
        self.tf: Tf = tf if truth else _without_truth(tf, self.sources)
        check_tf(self.tf, self.sources)
        self.pictures = Pictures(may_wait, is_behind)
        self.pings = Pings.all_of(self.sources, sim)
        self.maps = {
            source.name: PingMap(source, self.pings[source.name]) for source in self.sources if source.has_sonar
        }
        helms = {source.name: source.of(sim).helm for source in self.sources}
        self.rights = Rights(helms.values())
        shores = helms if sim.link is None else {name: Helm(name, lambda: None) for name in helms}
        self.steering = {
            source.name: Steering(source, self.rights, helms[source.name], shores[source.name])
            for source in self.sources
        }
        self.channels: list[Channel] = self._published(sim) if wire != "standard" else []
        self.published = frozenset(channel.name for channel in self.channels)
        self.has_standard = wire != "published"
        self.channels += self._standard(sim) if self.has_standard else []
        self.services: list[Service] = self._services(sim)
        for source in self.sources:
            taken = {each.name for each in self.channels} | {each.name for each in self.services}
            items = items_of(self._given(source, sim), taken)
            unserved = "" if self.has_standard else source.topic("save_map")  # maps grow with /octomap_binary
            self.services += [each for each in items if isinstance(each, Service) and each.name != unserved]
            if self.has_standard:
                self.channels += self._vehicles(source, [each for each in items if isinstance(each, Channel)])

        self.channels += logged_channels(sim, {each.name for each in self.channels}) if self.has_standard else []
        sim.logged.offered.add(self)

    def __repr__(self) -> str:
        return f"<Table of {len(self.channels)} channels and {len(self.services)} services>"

    def refresh(self) -> None:
        """Discard the latest pings and pictures, so that a recording starts with new ones.

        Runs on the simulator's thread.
        """
        for pings in self.pings.values():
            pings.forget()
        self.pictures.forget()

    @property
    def has_map(self) -> bool:
        """Whether any map has been started."""
        return any(ping_map.is_begun for ping_map in self.maps.values())

    def _published(self, sim: Simulator) -> list[Channel]:
        """Return the topics of the paper's simulator."""
        found = station_picture(self.pictures, sim, self.frame_prefix)
        for source in self.sources:
            pings, steering = self.pings.get(source.name), self.steering[source.name]
            tree = published_channels(source, sim, pings, self.pictures, steering)
            found += self._vehicles(source, [c for c in tree if self.truth or not c.name.endswith(TRUE_TOPICS)])
        return found

    def _standard(self, sim: Simulator) -> list[Channel]:
        """Return the usual ROS topics that belong to no vehicle."""
        found = frames.common_channels(
            self.sources, self.tf, self.frame_prefix, rate_hz=self.tf_rate_hz, joint_frames=self.joint_frames
        )
        found += station_cameras(sim, self.pictures, self.frame_prefix)
        found += object_tether_channels(sim) if self.truth else []
        return found

    def _vehicles(self, source: Source, channels: list[Channel]) -> list[Channel]:
        """Return a vehicle's channels, restricted by its link and by the right to command it."""
        return [
            replace(channel, authority=replace(channel.authority, door=self.steering[source.name]))
            if channel.direction == "in"
            else channel
            for channel in over_link(source, channels)
        ]

    def _given(self, source: Source, sim: Simulator) -> dict[str, Any]:
        """Return what the families of a vehicle may ask for, see `registered.GIVEN`."""
        return {
            "source": source, "sim": sim, "truth": self.truth, "tf": self.tf, "per_thruster": self._thruster_topics,
            "pings": self.pings.get(source.name), "maps": self.maps, "pictures": self.pictures,
            "steering": self.steering[source.name],
        }  # fmt: skip

    def _services(self, sim: Simulator) -> list[Service]:
        found = simulation_services() + parameter_services() + ([push_service()] if sim.objects else [])
        found += [stream_service(f"camera/{name}", name, self.pictures) for name in sim.cameras]
        return found


def _without_truth(tf: Tf, sources: Sequence[Source]) -> Tf:
    """Return the source of /tf when the truth is hidden: the estimate, or none if a vehicle has no estimate."""
    if tf != "truth":
        return tf
    return "odom" if all(map(has_estimate, sources)) else "none"


def over_link(source: Source, channels: list[Channel]) -> list[Channel]:
    """Return a vehicle's channels, with those that cross the link silenced while the vehicle is cut off."""

    def cut_off(read: Callable[[Simulator], Any]) -> Callable[[Simulator], Any]:
        return lambda sim: None if is_cut_off(sim, source.name) else read(sim)

    return [
        replace(channel, read=cut_off(channel.read)) if channel.over_link and channel.direction == "out" else channel
        for channel in channels
    ]


def channels(sim: Simulator, **options: Any) -> list[Channel]:
    """Return all channels of a simulator. options: as for Table."""
    return Table(sim, **options).channels


def check_tf(tf: str, sources: Sequence[Source]) -> None:
    """Raise ValueError if the source of /tf is unknown, or is the estimate and a vehicle has none."""
    if tf not in get_args(Tf):
        raise ValueError(f"tf = {tf!r}: must be one of {', '.join(get_args(Tf))}")
    for source in sources:
        if tf == "odom" and not has_estimate(source):
            raise ValueError(f"tf = 'odom': vehicle '{source.name}' has no IMU, by which it could estimate its motion")


def checked_rate(sim: Simulator, rate_hz: float) -> float:
    """Return the rate of /tf. Raises ValueError unless it is positive and at most one per step."""
    if not 0.0 < rate_hz <= (1.0 + 1e-9) / sim.step_s:
        raise ValueError(f"tf_rate_hz = {rate_hz:g} Hz: must be in (0, {1.0 / sim.step_s:g}] Hz, one per step at most")
    return rate_hz


def checked_wire(wire: str, origin: str | Sequence[float]) -> NDArray[np.float64]:
    """Return the origin (3,) in metres. Raises ValueError for an unknown wire or origin."""
    if wire not in ("standard", "published", "both"):
        raise ValueError(f"wire = {wire!r}: must be 'standard', 'published' or 'both'")
    return checked_origin(origin)


def checked_origin(origin: str | Sequence[float]) -> NDArray[np.float64]:
    """Return an origin (3,) in metres. Raises ValueError."""
    if isinstance(origin, str):
        if origin not in ORIGINS:
            raise ValueError(f"origin = {origin!r}: must be (x, y, z) in metres or one of {', '.join(ORIGINS)}")
        return np.array(ORIGINS[origin])
    position = np.asarray(origin, np.float64)
    if position.shape != (3,) or not np.isfinite(position).all():
        raise ValueError(f"origin = {origin!r}: must be (x, y, z) in metres or one of {', '.join(ORIGINS)}")
    return position
