"""The multibeam's channels, and messages built from a single ping."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.quaternions import of_matrix
from uwsim.channels.channel import PING, Channel, OverLink
from uwsim.channels.families.pings import Pings, TakenPing
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import PLACED_PING
from uwsim.channels.source import Source
from uwsim.mapping import ranging
from uwsim.mapping.ping_to_map import Box, PingToMap
from uwsim.simulator.simulator import Simulator

FLOAT32 = 7  # PointField.FLOAT32


class Head(Protocol):
    """The properties of a multibeam that a scan needs: its model, the time between pings, and the chain to a map."""

    @property
    def model(self) -> _core.MultibeamModel:
        """The multibeam's model."""

    @property
    def interval_s(self) -> float:
        """The time between pings [s]."""

    @property
    def chain(self) -> PingToMap:
        """The chain from a ping to a map, whose filters decide which echoes the scan contains."""


@dataclass(frozen=True)
class PingTopic:
    """A topic with one message per ping. At the 50 Hz of the paper's node, maps would count each ping several times.

    make: builds the message from head, ping and frame, or returns None for no message. packing: see Channel.
    """

    name: str
    type: str
    description: str
    make: Callable[[Head, TakenPing, str], Any]
    frame: str = "base_scan"
    packing: str = ""

    def channel(self, source: Source, pings: Pings) -> Channel:
        """Return the channel for a vehicle's latest ping."""
        frame_id = source.frame(self.frame) if self.frame else ""
        make = _once_a_ping(lambda taken: self.make(pings, taken, frame_id))
        period_ns = round(1e9 / pings.rate_hz)

        def read(sim: Simulator) -> Any:
            taken = pings.newest(sim)
            # Changed parameters may have made pings less frequent than the channel's readings.
            return make(taken) if sim.time_ns - taken.ping.time_ns < period_ns else None

        return Channel(
            source.topic(self.name), self.type, "out", self.description, rate_hz=pings.rate_hz, frame_id=frame_id,
            over_link=OverLink(PING, self.packing), read=read,
        )  # fmt: skip


def scan_of(head: Head, taken: TakenPing) -> ranging.LaserScan:
    """Convert a ping to a LaserScan of the echoes that belong in a map.

    As in the published decoder, ranges beyond the model's limit are infinite.
    """
    kept_m = _kept_m(head, taken)
    ranges = np.where(kept_m > head.model.range_limit_m, np.float32(np.inf), kept_m)
    return ranging.to_laser_scan(ranges, head.model, 1e-9 * taken.ping.time_ns, ping_interval_s=head.interval_s)


def scan_channels(source: Source, pings: Pings) -> list[Channel]:
    """Return the channels of a vehicle's multibeam."""
    return [topic.channel(source, pings) for topic in SCAN_TOPICS]


def _once_a_ping(make: Callable[[TakenPing], Any]) -> Callable[[TakenPing], Any]:
    """Cache the latest result of `make`, since several sinks read the same ping."""
    last: tuple[TakenPing, Any] | None = None

    def made(taken: TakenPing) -> Any:
        nonlocal last
        if last is None or last[0] is not taken:
            last = taken, make(taken)
        return last[1]

    return made


def _scan(head: Head, taken: TakenPing, frame_id: str) -> Any:
    scan = scan_of(head, taken)
    return build.message(
        "sensor_msgs/msg/LaserScan",
        header=build.header(taken.ping.time_ns, frame_id),
        angle_min=scan.angle_min,
        angle_max=scan.angle_max,
        angle_increment=scan.angle_increment,
        time_increment=scan.time_increment,
        scan_time=scan.scan_time,
        range_min=scan.range_min,
        range_max=scan.range_max,
        ranges=scan.ranges,
    )


def _projected(head: Head, taken: TakenPing, frame_id: str) -> Any:
    return cloud({"xyz": ranging.to_point_cloud(scan_of(head, taken))}, taken.ping.time_ns, frame_id)


def _echoes(head: Head, taken: TakenPing, frame_id: str) -> Any:
    ping, valid = taken.ping, taken.ping.valid
    ranges_m, angles_rad = ping.ranges_m[valid].astype(float), ping.angles_rad[valid].astype(float)
    xyz = np.column_stack([ranges_m * np.cos(angles_rad), ranges_m * np.sin(angles_rad), np.zeros(len(ranges_m))])
    return cloud({"xyz": xyz.astype(np.float32), "intensity": ping.intensity_db[valid]}, ping.time_ns, frame_id)


def _depths(head: Head, taken: TakenPing, frame_id: str) -> Any:
    if head.model.number not in ranging.MODELS:  # parameters may have changed the model
        return None
    return build.text(ranging.encode_depth_string(_kept_m(head, taken), head.model))


def _placed(head: Head, taken: TakenPing, frame_id: str) -> Any:
    sonar, scan = taken.odom_from_sonar, scan_of(head, taken)
    ranges_m = np.where(_on_hull(scan, taken, head.chain.hull), np.float32(np.inf), scan.ranges)
    return build.message(
        PLACED_PING,
        header=build.header(taken.ping.time_ns, frame_id),
        sonar=build.pose(sonar[:3, 3], of_matrix(sonar[:3, :3])),
        ranges=ranges_m,
        angle_min=scan.angle_min,
        angle_increment=scan.angle_increment,
    )


def _on_hull(scan: ranging.LaserScan, taken: TakenPing, hull: Box) -> NDArray[np.bool_]:
    """Return a mask (n,) of the beams of a scan that hit the vehicle's own hull."""
    body_from_sonar = ranging.relative_transform(taken.odom_from_body, taken.odom_from_sonar)
    farthest_m = np.linalg.norm(np.maximum(*np.abs(np.asarray(hull) - body_from_sonar[:3, 3])))  # the hull's corner
    if not ((scan.ranges > 0.0) & (scan.ranges < 1.001 * farthest_m)).any():
        return np.zeros(len(scan.ranges), bool)
    across, up = _directions(scan.angle_min, scan.angle_increment, len(scan.ranges))
    met = np.where(np.isfinite(scan.ranges), scan.ranges, 0.0).astype(np.float64)
    sonar = np.column_stack([met * across, met * up, np.zeros_like(met), np.ones_like(met)])
    body = (sonar @ body_from_sonar.T)[:, :3]
    return np.logical_and.reduce((body >= hull[0]) & (body <= hull[1]), axis=1) & (met > 0.0)  # type: ignore[no-any-return]


@lru_cache(16)
def _directions(first_rad: float, step_rad: float, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the cosines and sines (n,) of a scan's angles, which seldom change."""
    angles_rad = first_rad + step_rad * np.arange(count)
    return np.cos(angles_rad), np.sin(angles_rad)


def _kept_m(head: Head, taken: TakenPing) -> NDArray[np.float32]:
    return head.chain.kept_m(taken.ping.ranges_m, taken.deviation_m)


def cloud(columns: dict[str, NDArray[np.float32]], stamp_ns: int, frame_id: str) -> Any:
    """Build a PointCloud2 from float32 columns: xyz (n, 3), and any others (n,)."""
    names = ["x", "y", "z", *(name for name in columns if name != "xyz")]
    data = np.column_stack(list(columns.values())).astype("<f4")
    fields = [
        build.message("sensor_msgs/msg/PointField", name=name, offset=4 * k, datatype=FLOAT32, count=1)
        for k, name in enumerate(names)
    ]
    return build.message(
        "sensor_msgs/msg/PointCloud2",
        header=build.header(stamp_ns, frame_id),
        height=1,
        width=len(data),
        fields=fields,
        point_step=4 * len(names),
        row_step=4 * len(names) * len(data),
        data=data.view(np.uint8).ravel(),
        is_dense=True,
    )


SCAN_TOPICS = (
    PingTopic("scan", "sensor_msgs/msg/LaserScan", "each ping once, stamped with its time", _scan, packing="scan"),
    PingTopic("ping", "sensor_msgs/msg/LaserScan", "an earlier name of /scan", _scan, packing="scan"),
    PingTopic("laserPointCloud", "sensor_msgs/msg/PointCloud2", "the scan as laser_geometry projects it", _projected),
    PingTopic("points", "sensor_msgs/msg/PointCloud2", "all echoes of each ping with their intensity [dB]", _echoes),
)
DEPTH_ARRAY = PingTopic(
    "depthArray", "std_msgs/msg/String", "every beam's range [m], each followed by a; once for each ping", _depths,
    frame="", packing="depths",
)  # fmt: skip
PLACED = PingTopic(
    "placed_ping", PLACED_PING, "each ping with the sonar's pose, for building a map", _placed, frame="odom",
    packing="placed",
)  # fmt: skip
PING_TOPICS = (*SCAN_TOPICS, DEPTH_ARRAY, PLACED)
"""All topics that depend on a single ping."""
