"""The map built at the station from arriving pings, each of which includes the pose of its sonar."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels import Channel
from uwsim.channels.families.map import PUBLISH_NS, PingMap, binary, empty_map
from uwsim.channels.families.pings import Pings
from uwsim.channels.families.scans import PLACED
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.channels.table import Table
from uwsim.link.carried import Carried
from uwsim.mapping.ping_to_map import received_echoes
from uwsim.simulator.network import STATION, Network
from uwsim.simulator.simulator import Simulator

RANGE_MAX_M = 1000.0  # reported for scans whose sender has already applied its limit

OnRead = Callable[[str, Simulator], object]
"""A function called each time that the station reads a channel."""


class MapAshore(PingMap):
    """A map in the odom frame, built from the pings that have arrived at the station.

    Over a modem, where the next ping may take a long time to arrive, the changes made by a ping are published
    immediately; over other links, they are published on the same schedule as on board.
    """

    def __init__(
        self, source: Source, pings: Pings, carried: Carried, network: Network, on_read: OnRead | None = None
    ) -> None:
        super().__init__(source, pings)
        self._carried, self._network, self._on_read = carried, network, on_read
        self._is_slow = network.modem.kind == "modem"
        self._looked_ns = self._published_ns = 0
        self._is_new = self._has_changed = False
        self._last_whole: tuple[int, Any] = (-1, None)
        self._last_changes: tuple[int, Any] = (-1, None)

    def read(self, sim: Simulator) -> Any:
        """Return the map if new pings have arrived, at most once a second; otherwise None.

        Readers at the same simulated time get the same map.
        """
        if self._last_whole[0] != sim.time_ns:
            self._last_whole = sim.time_ns, self._new_map(sim)
        return self._last_whole[1]

    def read_changes(self, sim: Simulator) -> Any:
        """Return the changes made by the pings that have arrived since the last call, or None.

        Readers at the same simulated time get the same changes.
        """
        if self._last_changes[0] != sim.time_ns:
            self._last_changes = sim.time_ns, self._new_changes(sim)
        return self._last_changes[1]

    def _new_map(self, sim: Simulator) -> Any:
        self.update(sim)
        if not self._is_new or (self._is_slow and sim.time_ns < self._published_ns + PUBLISH_NS):
            return None
        self._is_new, self._published_ns = False, sim.time_ns
        if not self._is_slow:
            return super().read(sim)
        return self._message(self._newest_ns, self._worker.submit(binary, self._map).result())

    def _new_changes(self, sim: Simulator) -> Any:
        self.update(sim)
        if not self._has_changed:
            return None
        self._has_changed = False
        if not self._is_slow:
            return super().read_changes(sim)
        part = self._worker.submit(self._note_changes).result()
        return self._changes_message(self._newest_ns, (part, None))[0] if len(part.cells) else None

    def update(self, sim: Simulator) -> None:
        """Insert the pings that have arrived; start a new map if simulated time has gone back."""
        if self._on_read is not None:
            self._on_read(self._carried.channel.name, sim)  # a cable carries only the channels that are read
        if sim.time_ns < self._looked_ns:
            self._map, self._looked_ns, self._published_ns = None, 0, 0
        for message in arrived(self._network, self._carried, self._looked_ns):
            if self._map is None:
                self._map = empty_map(sim.scenario)
                self._worker.submit(self.changes.forget, self._map.resolution_m)
            self._newest_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            self._queue(*placed_points(message), self._pings.model.range_max_m)
            self._is_new = self._has_changed = True
        self._looked_ns = sim.time_ns


def arrived(network: Network, carried: Carried, after_ns: int) -> Iterable[Any]:
    """Return the messages of a channel that have arrived at the station since a time, oldest first."""
    for got in network.received(STATION, 1e-9 * after_ns):
        if got.topic == carried.channel.name:
            yield carried.packing.unpack(got.payload, carried.channel)


def placed_points(message: Any) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return the echoes (n, 3) of a PlacedPing and the sonar's position (3,), both in the message's frame."""
    from scipy.spatial.transform import Rotation  # slow to import

    ranges_m = np.asarray(message.ranges, np.float64)
    angles_rad = message.angle_min + message.angle_increment * np.arange(len(ranges_m))
    met = np.isfinite(ranges_m)
    across = np.column_stack([np.cos(angles_rad[met]), np.sin(angles_rad[met]), np.zeros(met.sum())])
    at, turn, pose = message.sonar.position, message.sonar.orientation, np.eye(4)
    pose[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    pose[:3, 3] = at.x, at.y, at.z
    return received_echoes(ranges_m[met, None] * across, pose), pose[:3, 3]


def with_scans(seen: Iterable[Channel]) -> list[Channel]:
    """Return the station's channels, with `ping` derived from the placed pings if the link does not carry it."""
    found = list(seen)
    names = {channel.name for channel in found}
    for channel in list(found):
        prefix, _, name = channel.name.rpartition("/")
        ping = f"{prefix}/ping" if prefix else "ping"
        if name == PLACED.name and ping not in names:
            scan = replace(
                channel, name=ping, type="sensor_msgs/msg/LaserScan", frame_id=f"{prefix}/base_scan".lstrip("/"),
                description="the beams of the placed pings that have arrived",
            )  # fmt: skip
            found.append(replace(scan, read=_scan_reader(channel, scan.frame_id), taped=None))
    return found


def _scan_reader(placed: Channel, frame_id: str) -> Callable[[Simulator], Any]:
    def read(sim: Simulator) -> Any:
        message = placed.read(sim)
        if message is None:
            return None
        header = build.message("std_msgs/msg/Header", stamp=message.header.stamp, frame_id=frame_id)
        last = message.angle_min + message.angle_increment * (len(message.ranges) - 1)
        return build.message(
            "sensor_msgs/msg/LaserScan", header=header, angle_min=message.angle_min, angle_max=last,
            angle_increment=message.angle_increment, range_min=0.0, range_max=RANGE_MAX_M, ranges=message.ranges,
        )  # fmt: skip

    return read


def maps_ashore(
    table: Table,
    network: Network,
    channels: Iterable[Channel],
    carried: dict[str, Carried],
    on_read: OnRead | None = None,
) -> list[Channel]:
    """Return the channels, with onboard maps replaced by maps built ashore, which the table's services then save."""
    aboard = {channel.name for ping_map in table.maps.values() for channel in ping_map.map_channels()}
    made: dict[str, Channel] = {}
    for source in table.sources:
        if source.name not in table.maps:
            continue
        one = carried.get(source.topic(PLACED.name))
        if one is None:
            del table.maps[source.name]
            continue
        table.maps[source.name] = MapAshore(source, table.pings[source.name], one, network, on_read)
        made |= {channel.name: channel for channel in table.maps[source.name].map_channels()}
    return [
        replace(made[channel.name], description=f"ashore: {channel.description}") if channel.name in made else channel
        for channel in channels
        if channel.name in made or channel.name not in aboard
    ]
