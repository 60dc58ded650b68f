"""The multibeam's channels: /scan, /laserPointCloud and /points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim import _core, ranging
from uwsim.channels import build
from uwsim.channels.channel import Channel
from uwsim.channels.pings import Pings, TakenPing
from uwsim.channels.source import Source

SCAN_HZ = 50.0
FLOAT32 = 7  # PointField.FLOAT32


class Head(Protocol):
    """What a scan says about the multibeam: its model, and the time from ping to ping [s]."""

    @property
    def model(self) -> _core.MultibeamModel:
        """The model."""

    @property
    def interval_s(self) -> float:
        """The interval."""


def scan_of(head: Head, taken: TakenPing) -> ranging.LaserScan:
    """Return a ping as a LaserScan: ranges beyond the model's limit are infinite, as the published decoder has it."""
    ranges = np.where(taken.ping.ranges_m > head.model.range_limit_m, np.float32(np.inf), taken.ping.ranges_m)
    return ranging.to_laser_scan(ranges, head.model, 1e-9 * taken.ping.time_ns, ping_interval_s=head.interval_s)


def scan_channels(source: Source, pings: Pings) -> list[Channel]:
    """Return the channels of a vehicle's multibeam."""
    frame_id = source.frame("base_scan")

    def channel(name: str, kind: str, hz: float, description: str, make: Callable[[TakenPing], Any]) -> Channel:
        make = _once_a_ping(make)
        return Channel(
            source.topic(name), f"sensor_msgs/msg/{kind}", "out", description, rate_hz=hz, frame_id=frame_id,
            over_link=True, read=lambda sim: make(pings.newest(sim)),
        )  # fmt: skip

    return [
        channel(
            "scan", "LaserScan", SCAN_HZ, "the newest ping, stamped with its time",
            lambda p: _scan(pings, p, frame_id),
        ),
        channel(
            "ping", "LaserScan", pings.rate_hz, "each ping once, as /scan says it",
            lambda p: _scan(pings, p, frame_id),
        ),
        channel(
            "laserPointCloud", "PointCloud2", SCAN_HZ, "the scan as laser_geometry projects it",
            lambda p: cloud({"xyz": ranging.to_point_cloud(scan_of(pings, p))}, p.ping.time_ns, frame_id),
        ),
        channel(
            "points", "PointCloud2", pings.rate_hz, "each ping's echoes with their intensity [dB]",
            lambda p: cloud(_echoes(p), p.ping.time_ns, frame_id),
        ),
    ]  # fmt: skip


def _once_a_ping(make: Callable[[TakenPing], Any]) -> Callable[[TakenPing], Any]:
    """Return a function that gives the same message for the same ping: several are said of each."""
    last: tuple[TakenPing, Any] | None = None

    def made(taken: TakenPing) -> Any:
        nonlocal last
        if last is None or last[0] is not taken:
            last = taken, make(taken)
        return last[1]

    return made


def _scan(pings: Pings, taken: TakenPing, frame_id: str) -> Any:
    scan = scan_of(pings, taken)
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


def _echoes(taken: TakenPing) -> dict[str, NDArray[np.float32]]:
    ping = taken.ping
    return {"xyz": ping.points_sonar_m[ping.valid], "intensity": ping.intensity_db[ping.valid]}


def cloud(columns: dict[str, NDArray[np.float32]], stamp_ns: int, frame_id: str) -> Any:
    """Return a PointCloud2 of float32 columns: xyz (n, 3), others (n,)."""
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
