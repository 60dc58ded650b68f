"""The ROS 2 node: the cost of a message, and the messages that reach a node with ROS 2's default middleware.

The reader is tests/fast_dds/fast_dds_peer.cpp (Fast DDS, Fast CDR), a separate process on this machine, built by
`tools/setup --dev`. Costs are CPU time of all our threads, including Cyclone DDS's; latencies are measured from the
reading on the simulator's thread to the decoded message. Each value is printed with its goal.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import console
from rich.table import Table

from uwsim.bridges.ros2 import Ros2Node, Ros2Settings
from uwsim.channels import Channel, Delivery
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/python"))  # the peer is shared with the tests

SCAN, CLOUD, IMAGE = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/Image"
IMU, TWIST, TF = "sensor_msgs/msg/Imu", "geometry_msgs/msg/Twist", "tf2_msgs/msg/TFMessage"
ODOMETRY = "nav_msgs/msg/Odometry"
GOALS_US = {SCAN: 30.0, CLOUD: 250.0, IMAGE: 350.0}
# Type and rate of each topic: 690 messages per second in total, the most that readings at a step of 5 ms allow.
MIXED = {
    "scan": (SCAN, 40.0), "cloud": (CLOUD, 20.0), "image": (IMAGE, 10.0), "imu": (IMU, 200.0), "tf": (TF, 200.0),
    "odom": (ODOMETRY, 200.0), "twist": (TWIST, 20.0),
}  # fmt: skip
SWITCH_S = 0.0005  # as uwsim serve sets it


def messages() -> dict[str, Any]:
    """Return one message of each kind: a scan of 1,025 beams, a cloud of 30,000 points, a 1 MB picture, and so on."""
    rng = np.random.default_rng(1)
    header = build.header(0, "base_scan")
    fields = [build.message("sensor_msgs/msg/PointField", name=n, offset=4 * k, datatype=7, count=1)
              for k, n in enumerate(("x", "y", "z", "intensity"))]  # fmt: skip
    points = rng.random((30_000, 4), np.float32).view(np.uint8).ravel()
    return {
        SCAN: build.message(SCAN, header=header, ranges=rng.random(1025, np.float32), range_max=95.0),
        CLOUD: build.message(CLOUD, header=header, height=1, width=30_000, fields=fields, point_step=16,
                             row_step=480_000, data=points, is_dense=True),
        IMAGE: build.message(IMAGE, header=header, height=577, width=577, encoding="rgb8", step=1731,
                             data=rng.integers(0, 255, 577 * 1731, np.uint8)),
        IMU: build.message(IMU, header=header),
        TF: build.message(TF, transforms=[build.transform(0, "odom", "base_link", (1.0, 2.0, 3.0))]),
        ODOMETRY: build.message(ODOMETRY, header=header),
        TWIST: build.message(TWIST),
    }  # fmt: skip


def stamped(message: Any) -> Any:
    """Return a copy stamped with the wall-clock time, from which latency is measured."""
    copy = type(message)(**vars(message))
    if hasattr(copy, "header"):
        copy.header = build.header(time.monotonic_ns(), message.header.frame_id)
    return copy


class Row(dict[str, Any]):
    """One result: name, value, unit, goal, and whether the goal is a minimum or a maximum."""

    def __init__(self, what: str, value: float, unit: str, goal: float | None = None, *, least: bool = False) -> None:
        super().__init__(what=what, value=value, unit=unit, goal=goal, least=least)


def main(
    seconds: Annotated[float, typer.Option(min=1.0, help="Length of each measurement [s].")] = 8.0,
    domain_id: Annotated[int, typer.Option(help="The ROS domain, which nothing else should use.")] = 96,
    memory_messages: Annotated[int, typer.Option(help="Messages after which memory is compared.")] = 100_000,
) -> dict[str, Any]:
    """Measure all cases in turn and print the results."""
    from fast_dds import BINARY

    if not BINARY.is_file():
        raise ValueError(f"{BINARY}: is not there; tools/setup --dev builds it")
    sys.setswitchinterval(SWITCH_S)
    settings = Ros2Settings(domain_id=domain_id)
    rows: list[Row] = []
    with LiveSimulator(Simulator("lake"), speed=1.0) as live:
        for case in (encode_and_write, mixed, delivered, commanded, stalled, closing):
            with console.status(case.__name__):
                rows += case(live, settings, seconds)
        with console.status("memory"):
            rows += memory(live, settings, memory_messages)
    table = Table("quantity", "value", "goal")
    for row in rows:
        bound = "at least" if row["least"] else "at most"
        goal = "" if row["goal"] is None else f"{bound} {row['goal']:g} {row['unit']}"
        table.add_row(row["what"], f"{row['value']:.4g} {row['unit']}", goal)
    console.print(table)
    return {"rows": rows}


def encode_and_write(live: LiveSimulator, settings: Ros2Settings, seconds: float) -> list[Row]:
    """Return the CPU time of a message, encoded and written to one reader that receives all."""
    from fast_dds import fast_dds_peer, sub
    from ros2_tools import Peer
    from uwsim.bridges.ros2.graph import dds_name
    from uwsim.bridges.ros2.qos import writer_qos
    from uwsim.bridges.ros2.transport import DEPTH
    from waiting import until

    rows = []
    for kind, message in messages().items():
        if kind not in GOALS_US:
            continue
        ours = Peer(settings)
        qos = writer_qos(DEPTH, latched=False, user_data=b"")
        writer = ours.participant.writer(dds_name("bench"), kind, qos)
        with fast_dds_peer(settings.domain_id, *sub("bench", kind)) as other:
            until(writer.readers)
            costs, calls = [], []
            for _ in range(20):  # as fast as possible, but only a few messages at a time so that the reader keeps up
                cpu = time.process_time()
                for _ in range(10):
                    began = time.thread_time()
                    writer.write(encode(message))
                    calls.append(time.thread_time() - began)
                costs.append((time.process_time() - cpu) / 10)
                time.sleep(0.1)
            other.wait_for("rt/bench", 1)
        ours.participant.close()
        name = f"{kind.rsplit('/', 1)[1]}, {len(encode(message)):,} bytes: encode and write"
        rows.append(Row(name, 1e6 * float(np.median(calls)), "us", GOALS_US[kind]))
        rows.append(Row("the same with Cyclone DDS's own threads", 1e6 * float(np.median(costs)), "us"))
    return rows


def mixed(live: LiveSimulator, settings: Ros2Settings, seconds: float) -> list[Row]:
    """Return the fraction of a core that 690 mixed messages per second use in addition to the simulator."""
    from fast_dds import fast_dds_peer, sub

    found = messages()
    table = [
        Channel(f"bench/{name}", kind, "out", "", rate_hz=hz, read=lambda sim, kind=kind: stamped(found[kind]))
        for name, (kind, hz) in MIXED.items()
    ]
    idle = cpu_share(seconds)
    with Ros2Node(live, table, (), settings) as node:
        words = [word for channel in table for word in sub(channel.name, channel.type)]
        with fast_dds_peer(settings.domain_id, *words) as other:
            for channel in table:
                other.wait_for(f"rt/{channel.name}", 2)
            before, began = sum(node.written.values()), time.monotonic()
            share = cpu_share(seconds)
            rate = (sum(node.written.values()) - before) / (time.monotonic() - began)
            lines = [line for channel in table for line in other.messages(f"rt/{channel.name}")]
    return [
        Row("mixed messages", rate, "1/s", 690.0 * 0.99, least=True),
        Row("share of a core for them", 100.0 * (share - idle), "%", 15.0),
        *latencies(lines, table),
    ]


def latencies(lines: list[dict[str, Any]], table: list[Channel]) -> list[Row]:
    """Return the median and the 99th percentile for each kind whose stamp the peer decodes."""
    rows = []
    for channel in table:
        times_ms = [
            1e-6 * (line["now_ns"] - line["stamp_ns"])
            for line in lines
            if line["topic"] == f"rt/{channel.name}" and line.get("stamp_ns")
        ]
        if times_ms:
            p50, p99 = np.percentile(times_ms, (50, 99))
            rows.append(Row(f"{channel.name[6:]}: latency, median", float(p50), "ms"))
            rows.append(Row(f"{channel.name[6:]}: latency, 99 %", float(p99), "ms"))
    return rows


def cpu_share(seconds: float) -> float:
    """Return this process's CPU time per wall time."""
    cpu, wall = time.process_time(), time.monotonic()
    time.sleep(seconds)
    return (time.process_time() - cpu) / (time.monotonic() - wall)


def delivered(live: LiveSimulator, settings: Ros2Settings, seconds: float) -> list[Row]:
    """Return the delivered fractions of scans at 40 Hz and clouds at 20 Hz, and a late reader's latched messages."""
    from fast_dds import fast_dds_peer, sub

    found = messages()
    table = [
        Channel("scan", SCAN, "out", "", rate_hz=40.0, read=lambda sim: stamped(found[SCAN])),
        Channel("cloud", CLOUD, "out", "", rate_hz=20.0, read=lambda sim: stamped(found[CLOUD])),
        Channel("static", TF, "out", "", delivery=Delivery(latched=True), read=lambda sim: found[TF]),
    ]
    rows = []
    for reliability in ("best_effort", "reliable"):
        with Ros2Node(live, table, (), settings) as node:
            words = [*sub("scan", SCAN, reliability), *sub("cloud", CLOUD, reliability)]
            with fast_dds_peer(settings.domain_id, *words) as other:
                other.wait_for("rt/cloud", 2)
                other.wait_for("rt/scan", 2)
                start = {name: len(other.messages(f"rt/{name}")) for name in ("scan", "cloud")}
                before = dict(node.written)
                time.sleep(seconds)
                sent = {name: node.written[name] - before[name] for name in start}
                time.sleep(0.5)
                for name in start:
                    got = len(other.messages(f"rt/{name}")) - start[name]
                    share = 100.0 * min(got / sent[name], 1.0)
                    rows.append(Row(f"{name}s delivered, {reliability}", share, "%", 99.0, least=True))
            with fast_dds_peer(settings.domain_id, *sub("static", TF, "reliable", "latched")) as late:
                count = len(late.wait_for("rt/static", 1))
                rows.append(Row("latched messages that a late reader got", count, "", 1.0, least=True))
    return rows


def commanded(live: LiveSimulator, settings: Ros2Settings, seconds: float) -> list[Row]:
    """Return the fraction of commands at 100 Hz that arrive."""
    from fast_dds import fast_dds_peer
    from waiting import until

    heard: list[float] = []
    channel = Channel("cmd_vel", TWIST, "in", "", apply=lambda live, message: heard.append(message.linear.x))
    with Ros2Node(live, [channel], (), settings), fast_dds_peer(settings.domain_id, "pub", "rt/cmd_vel", "100"):
        until(lambda: heard)
        time.sleep(seconds)
        counts = np.round(1e3 * np.array(heard)).astype(int)
    return [Row("/cmd_vel delivered", 100.0 * len(counts) / (counts[-1] - counts[0] + 1), "%", 95.0, least=True)]


def stalled(live: LiveSimulator, settings: Ros2Settings, seconds: float) -> list[Row]:
    """Return the longest write while a reader of 1 MB pictures is stopped."""
    from fast_dds import fast_dds_peer, sub
    from uwsim.bridges.ros2.dds import RawWriter

    picture, times_s = messages()[IMAGE], []
    table = [Channel("picture", IMAGE, "out", "", rate_hz=20.0, read=lambda sim: stamped(picture))]
    plain = RawWriter.write

    def timed(self: RawWriter, cdr: memoryview) -> bool:
        began = time.monotonic()
        taken = plain(self, cdr)
        times_s.append(time.monotonic() - began)
        return taken

    with (
        Ros2Node(live, table, (), settings) as node,
        fast_dds_peer(settings.domain_id, *sub("picture", IMAGE)) as other,
    ):
        other.wait_for("rt/picture", 2)
        os.kill(other.process.pid, signal.SIGSTOP)
        RawWriter.write = timed  # type: ignore[method-assign]
        try:
            time.sleep(seconds)
            before, began = node.written["picture"], time.monotonic()
            time.sleep(1.0)
            rate = (node.written["picture"] - before) / (time.monotonic() - began)
        finally:
            RawWriter.write = plain  # type: ignore[method-assign]
            os.kill(other.process.pid, signal.SIGCONT)
    return [
        Row("a stopped reader: the longest write", 1e3 * max(times_s), "ms", 100.0),
        Row("a stopped reader: pictures written", rate, "1/s", 19.0, least=True),
    ]


def closing(live: LiveSimulator, settings: Ros2Settings, seconds: float) -> list[Row]:
    """Return the time that closing takes while messages are sent, and the number of threads that remain."""
    from fast_dds import fast_dds_peer, sub

    before = threading.active_count()
    scan = messages()[SCAN]
    table = [Channel("scan", SCAN, "out", "", rate_hz=50.0, read=lambda sim: stamped(scan))]
    node = Ros2Node(live, table, (), settings)
    with fast_dds_peer(settings.domain_id, *sub("scan", SCAN)) as other:
        other.wait_for("rt/scan", 2)
        began = time.monotonic()
        node.close()
        took_s = time.monotonic() - began
    return [
        Row("closing", took_s, "s", 1.0),
        Row("threads left by the node", threading.active_count() - before, "", 0.0),
    ]


def memory(live: LiveSimulator, settings: Ros2Settings, count: int) -> list[Row]:
    """Return the growth of memory over many scans, published as fast as possible to a reader in this process."""
    from ros2_tools import Peer
    from waiting import until

    scan = messages()[SCAN]
    sender, receiver = Peer(settings), Peer(settings)
    receiver.listen("bench", SCAN)
    writer = sender.writer("bench", SCAN)
    heard = 0

    def flow(messages: int) -> float:
        nonlocal heard
        for k in range(messages):
            writer.write(encode(scan))
            if k % 50 == 0:
                heard += len(receiver.heard("bench"))
        until(lambda: not receiver.heard("bench"))
        return resident_mb()

    before = flow(count // 10)
    grown = flow(count) - before
    for side in (sender, receiver):
        side.participant.close()
    return [Row(f"memory after {count:,} messages more", grown, "MB", 5.0)]


def resident_mb() -> float:
    """Return the resident memory of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
