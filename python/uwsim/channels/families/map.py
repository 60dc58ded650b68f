"""Channels of the map of all pings since a server started: /octomap_binary, /map_changes and /placed_ping."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.families.map_changes import MapChanges
from uwsim.channels.families.pings import Pings, TakenPing
from uwsim.channels.families.scans import PLACED, Head
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import MAP_CHANGES
from uwsim.channels.source import Source
from uwsim.mapping import OccupancyMap
from uwsim.scenario import Scenario
from uwsim.scenario.build.multibeam import map_voxel_m
from uwsim.simulator.simulator import Simulator

PUBLISH_NS, CHANGES_NS = 1_000_000_000, 250_000_000
WAITING_MAX = 64  # pings that may be queued for the map; beyond that, the steps wait


class _Late:
    """A result computed every period_ns from the latest ping and published one ping later, except for the first."""

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._newest_ns = -1
        self._begun: tuple[int, Future[Any]] | None = None  # the result begun at the latest ping, if any
        self._due: tuple[int, Future[Any]] | None = None  # the result to publish at the latest ping

    def at_ping(self, stamp_ns: int, interval_ns: int, begin: Callable[[], Future[Any]]) -> None:
        """Register a ping; further calls for the same ping do nothing."""
        if stamp_ns == self._newest_ns:
            return
        is_first = self._newest_ns < 0 or stamp_ns < self._newest_ns
        is_due = is_first or stamp_ns // self._period_ns != (stamp_ns - interval_ns) // self._period_ns
        self._newest_ns = stamp_ns
        self._due = self._begun
        self._begun = (stamp_ns, begin()) if is_due else None
        self._due = self._begun if is_first else self._due

    @property
    def due(self) -> tuple[int, Any] | None:
        """The stamp and result now due, or None; waits for the result."""
        return None if self._due is None else (self._due[0], self._due[1].result())


class PingMap:
    """A map, in the odom frame, of all pings since a server began to offer it, with or without subscribers.

    For each ping, the simulation waits only for ray casting and the processing chain. Insertion and serialisation run
    in order on a separate thread. Each map is published one ping later, except the first, which is published at once.
    """

    def __init__(self, source: Source, pings: Pings) -> None:
        self._source = source
        self._pings = pings
        self._map: OccupancyMap | None = None
        self._newest_ns = -1
        self._worker = ThreadPoolExecutor(1, "uwsim-map")
        self._waiting: deque[Future[None]] = deque()
        self._whole, self._news = _Late(PUBLISH_NS), _Late(CHANGES_NS)
        self.changes = MapChanges()

    @property
    def is_begun(self) -> bool:
        """Whether the map contains any pings."""
        return self._map is not None

    def channels(self) -> list[Channel]:
        """Return the map's channels, and the channel of pings from which clients can build their own map."""
        return [*self.map_channels(), PLACED.channel(self._source, self._pings)]

    def map_channels(self) -> list[Channel]:
        """Return the channels of the map itself."""
        rate_hz, frame_id = self._pings.rate_hz, self._source.frame("odom")
        return [
            Channel(
                self._source.topic("octomap_binary"), "octomap_msgs/msg/Octomap", "out",
                "the map of all pings since the server began, once a second", rate_hz=rate_hz,
                frame_id=frame_id, read=self.read, delivery=Delivery(latched=True, update=self.update),
            ),
            Channel(
                self._source.topic("map_changes"), MAP_CHANGES, "out",
                "voxels of the same map that became occupied or unoccupied, four times a second",
                rate_hz=rate_hz, frame_id=frame_id, read=self.read_changes,
                delivery=Delivery(latched=True, catch_up=self._catch_up),
            ),
        ]  # fmt: skip

    def read(self, sim: Simulator) -> Any:
        """Insert the latest ping. Return the map of the previous reading once a second, otherwise None."""
        self.update(sim)
        self._whole.at_ping(self._newest_ns, self._interval_ns, lambda: self._worker.submit(binary, self._map))
        due = self._whole.due
        return None if due is None else self._message(*due)

    def read_changes(self, sim: Simulator) -> Any:
        """Insert the latest ping. Return the changes up to the previous reading, if any, four times a second."""
        self.update(sim)
        self._news.at_ping(self._newest_ns, self._interval_ns, lambda: self._worker.submit(self._note_changes))
        due = self._news.due
        if due is None or not len(due[1].cells):
            return None
        return self._changes_message(due[0], (due[1], None))[0]

    def go_on_from(self, path: Path) -> None:
        """Continue from a map in a file. Must be called before the first ping. Raises ValueError or OSError."""
        self._map = OccupancyMap.read(path, on_outside="count")
        self._worker.submit(self.changes.forget, self._map.resolution_m)

    def points(self) -> tuple[NDArray[np.float64], float]:
        """Return the centres (n, 3) of occupied voxels in odom, and their edge length [m]. Raises ValueError."""
        return self._worker.submit(self._points).result()

    def write(self, path: Path) -> None:
        """Write the map with all pings so far. Raises ValueError if there is no map yet, or OSError."""
        self._worker.submit(self._write, path).result()

    def to_bytes(self) -> bytes:
        """Return the map with all pings so far as .bt data. Raises ValueError if there is no map yet."""
        return self._worker.submit(lambda: self._some_map().to_bytes("bt")).result()

    @property
    def _interval_ns(self) -> int:
        return round(self._pings.interval_s * 1e9)

    def update(self, sim: Simulator) -> None:
        """Insert the latest ping unless the map already contains it."""
        taken = self._pings.newest(sim)
        if taken.ping.time_ns != self._newest_ns:
            self._insert(sim, taken)

    def _insert(self, sim: Simulator, taken: TakenPing) -> None:
        """Process a ping and insert its points into the map. If simulated time has gone back, start a new map."""
        if self._map is None or taken.ping.time_ns < self._newest_ns:
            self._map = empty_map(sim.scenario)
            self._worker.submit(self.changes.forget, self._map.resolution_m)
        self._newest_ns = taken.ping.time_ns
        points_odom = mapped_points(self._pings, taken)
        self._queue(points_odom, taken.odom_from_sonar[:3, 3], self._pings.model.range_max_m)

    def _queue(self, points_odom: NDArray[np.float32], origin_m: NDArray[np.float64], reach_m: float) -> None:
        """Queue a scan for insertion on the worker thread; wait if too many are queued."""
        assert self._map is not None
        self._waiting.append(self._worker.submit(self._map.insert_scan, points_odom, origin_m, reach_m))
        while len(self._waiting) > WAITING_MAX or (self._waiting and self._waiting[0].done()):
            self._waiting.popleft().result()

    def _note_changes(self) -> Any:
        """Move changes from the map to the list of changes, on the worker thread."""
        assert self._map is not None
        return self.changes.note(self._map.changed_occupancy())

    def _catch_up(self, cursor: Any) -> tuple[Any, Any]:
        return self._changes_message(self._newest_ns, self.changes.since(cursor))

    def _changes_message(self, stamp_ns: int, found: tuple[Any, Any]) -> tuple[Any, Any]:
        part, cursor = found
        header = build.header(max(stamp_ns, 0), self._source.frame("odom"))
        return build.message(MAP_CHANGES, header=header, **part._asdict()), cursor

    def _message(self, stamp_ns: int, data: bytes) -> Any:
        assert self._map is not None
        return build.message(
            "octomap_msgs/msg/Octomap",
            header=build.header(stamp_ns, self._source.frame("odom")),
            binary=True,
            id="OcTree",
            resolution=self._map.resolution_m,
            data=np.frombuffer(data, np.int8),
        )

    def _write(self, path: Path) -> None:
        self._some_map().write(path)

    def _points(self) -> tuple[NDArray[np.float64], float]:
        occupancy = self._some_map()
        return occupancy.occupied_voxels(), occupancy.resolution_m

    def _some_map(self) -> OccupancyMap:
        if self._map is None:
            raise ValueError(
                f"there is no map yet: no server has begun to offer '{self._source.topic('octomap_binary')}'"
            )
        return self._map


def map_channels(source: Source, maps: Mapping[str, PingMap]) -> list[Channel]:
    """Return the channels of a vehicle's map, if it has a multibeam."""
    return maps[source.name].channels() if source.name in maps else []


def empty_map(scenario: Scenario) -> OccupancyMap:
    """Return an empty map with the voxel size of the scenario's maps."""
    return OccupancyMap(map_voxel_m(scenario), on_outside="count")


def mapped_points(head: Head, taken: TakenPing) -> NDArray[np.float32]:
    """Pass a ping through the chain and return its points (n, 3) in odom."""
    ping, stamp_s = taken.ping, 1e-9 * taken.ping.time_ns
    return head.chain.echoes(ping.ranges_m, taken.odom_from_body, taken.odom_from_sonar, stamp_s, taken.deviation_m)


def insert_ping(occupancy: OccupancyMap, head: Head, taken: TakenPing) -> None:
    """Pass a ping through the chain and insert its points into a map."""
    occupancy.insert_scan(mapped_points(head, taken), taken.odom_from_sonar[:3, 3], head.model.range_max_m)


def binary(occupancy: OccupancyMap | None) -> bytes:
    """Return the data expected by octomap_msgs::binaryMsgToMap: a .bt file without its header."""
    assert occupancy is not None
    return occupancy.to_bytes("bt").partition(b"\ndata\n")[2]
