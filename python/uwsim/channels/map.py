"""The map that the newest pings make: /octomap_binary."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from uwsim import ranging
from uwsim.channels import build
from uwsim.channels.channel import Channel
from uwsim.channels.pings import Pings, TakenPing
from uwsim.channels.scans import scan_of
from uwsim.channels.source import Source
from uwsim.mapping import OccupancyMap
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.simulator import Simulator

PUBLISH_NS = 1_000_000_000
HULL_MARGIN_M = 0.05
WAITING_MAX = 64  # pings that may wait for the map; more make the steps wait


class PingMap:
    """A map in the odom frame. Each reading at the rate of the pings inserts the newest: it grows while it is read.

    Inserting and writing happen in order on a thread of its own. A map that is said arrives one ping later, the first
    at once.
    """

    def __init__(self, source: Source, pings: Pings) -> None:
        self._source = source
        self._pings = pings
        self._map: OccupancyMap | None = None
        self._newest_ns = -1
        self._worker = ThreadPoolExecutor(1, "uwsim-map")
        self._waiting: deque[Future[None]] = deque()
        self._begun: tuple[int, Future[bytes]] | None = None  # at the newest ping
        self._said: tuple[int, Future[bytes]] | None = None  # by whoever reads at the newest ping
        vertices, _ = vehicle_hull(source.entry.model)
        self._low_m, self._high_m = vertices.min(axis=0) - HULL_MARGIN_M, vertices.max(axis=0) + HULL_MARGIN_M

    def channel(self) -> Channel:
        """Return the channel."""
        return Channel(
            self._source.topic("octomap_binary"), "octomap_msgs/msg/Octomap", "out",
            "the map of the pings since somebody first listened, once a second", rate_hz=self._pings.rate_hz,
            latched=True, frame_id=self._source.frame("odom"), read=self.read,
        )  # fmt: skip

    def read(self, sim: Simulator) -> Any:
        """Insert the newest ping; return the map that was begun at the last reading, once a second, else None."""
        taken = self._pings.newest(sim)
        stamp_ns = taken.ping.time_ns
        if stamp_ns != self._newest_ns:
            is_first = self._insert(sim, taken)
            before_ns = stamp_ns - round(self._pings.interval_s * 1e9)
            is_due = is_first or stamp_ns // PUBLISH_NS != before_ns // PUBLISH_NS
            self._said = self._begun
            self._begun = (stamp_ns, self._worker.submit(_binary, self._map)) if is_due else None
            self._said = self._begun if is_first else self._said
        return None if self._said is None else self._message(*self._said)

    def write(self, path: Path) -> None:
        """Write the map, with every ping so far. Raises ValueError if there is none yet, OSError."""
        self._worker.submit(self._write, path).result()

    def _insert(self, sim: Simulator, taken: TakenPing) -> bool:
        """Pass a ping through the chain towards the map; return whether it is a new one: if time has gone back."""
        is_first = self._map is None or taken.ping.time_ns < self._newest_ns
        if is_first:
            survey = sim.scenario.survey
            self._map = OccupancyMap(survey.voxel_m if survey else 0.2, on_outside="count")
        self._newest_ns = taken.ping.time_ns
        body_from_sonar = np.linalg.inv(taken.odom_from_body) @ taken.odom_from_sonar
        points = ranging.transform_points(ranging.to_point_cloud(scan_of(self._pings, taken)), body_from_sonar)
        others = ranging.remove_box(points, self._low_m, self._high_m)
        points_odom = ranging.transform_points(others, taken.odom_from_body)
        origin_m, reach_m = taken.odom_from_sonar[:3, 3], self._pings.model.range_max_m
        assert self._map is not None
        self._waiting.append(self._worker.submit(self._map.insert_scan, points_odom, origin_m, reach_m))
        while len(self._waiting) > WAITING_MAX or (self._waiting and self._waiting[0].done()):
            self._waiting.popleft().result()
        return is_first

    def _message(self, stamp_ns: int, data: Future[bytes]) -> Any:
        assert self._map is not None
        return build.message(
            "octomap_msgs/msg/Octomap",
            header=build.header(stamp_ns, self._source.frame("odom")),
            binary=True,
            id="OcTree",
            resolution=self._map.resolution_m,
            data=np.frombuffer(data.result(), np.int8),
        )

    def _write(self, path: Path) -> None:
        if self._map is None:
            raise ValueError(f"there is no map yet: subscribe to '{self._source.topic('octomap_binary')}' first")
        self._map.write(path)


def _binary(occupancy: OccupancyMap | None) -> bytes:
    """Return what octomap_msgs::binaryMsgToMap reads: the file without its header."""
    assert occupancy is not None
    return occupancy.to_bytes("bt").partition(b"\ndata\n")[2]
