"""The ROS 2 node: the cost of a message, and the messages that reach a node with ROS 2's default middleware.

The reader is tests/fast_dds/fast_dds_peer.cpp (Fast DDS, Fast CDR), a separate process on this machine, built by
`tools/setup --dev`. Costs are CPU time.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import SCAN, SWITCH_S, console, cores_used, resident_mb, show, spent_s, stamped

from uwsim.bridges.ros2 import Ros2Node, Ros2Settings
from uwsim.channels import Channel, Delivery
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

CLOUD, IMAGE = "sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/Image"
IMU, TWIST, TF = "sensor_msgs/msg/Imu", "geometry_msgs/msg/Twist", "tf2_msgs/msg/TFMessage"
ODOMETRY = "nav_msgs/msg/Odometry"
# Type and rate of each topic: 690 messages per second in total, the most that readings at a step of 5 ms allow.
MIXED = {
    "scan": (SCAN, 40.0), "cloud": (CLOUD, 20.0), "image": (IMAGE, 10.0), "imu": (IMU, 200.0), "tf": (TF, 200.0),
    "odom": (ODOMETRY, 200.0), "twist": (TWIST, 20.0),
}  # fmt: skip
GOALS = {
    "LaserScan: encode and write [us]": "<= 30",
    "PointCloud2: encode and write [us]": "<= 250",
    "Image: encode and write [us]": "<= 350",
    "mixed messages [1/s]": ">= 683",
    "cores for them": "<= 0.15",
    **{f"{name}s delivered, {how}": ">= 0.99" for name in ("scan", "cloud") for how in ("best_effort", "reliable")},
    "latched messages that a late reader got": ">= 1",
    "/cmd_vel delivered": ">= 0.95",
    "longest write while a reader is stopped [ms]": "<= 100",
    "pictures written meanwhile [1/s]": ">= 19",
    "closing [s]": "<= 1",
    "threads left by the node": "<= 0",
    "memory of the further messages [MB]": "<= 5",
}


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


MESSAGES = messages()


def channel(name: str, kind: str, rate_hz: float) -> Channel:
    """Return a channel that repeats a message with new stamps."""
    return Channel(name, kind, "out", "", rate_hz=rate_hz, read=lambda sim: stamped(MESSAGES[kind]))


def main(
    seconds: Annotated[float, typer.Option(min=1.0, help="Length of each measurement [s].")] = 8.0,
    domain_id: Annotated[int, typer.Option(help="The ROS domain, which nothing else should use.")] = 96,
    memory_messages: Annotated[int, typer.Option(help="Messages after which memory is compared.")] = 100_000,
) -> dict[str, Any]:
    """Measure all cases in turn and print the results."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests/python"))  # the peer is shared with the tests
    import fast_dds

    if not fast_dds.BINARY.is_file():
        raise ValueError(f"{fast_dds.BINARY}: is not there; tools/setup --dev builds it")
    sys.setswitchinterval(SWITCH_S)
    results: dict[str, float] = {}
    with LiveSimulator(Simulator("lake"), speed=1.0) as live:
        bench = Bench(fast_dds, live, Ros2Settings(domain_id=domain_id), seconds)
        for case in (bench.encode_and_write, bench.mixed, bench.delivered, bench.commanded, bench.stalled,
                     bench.closing):  # fmt: skip
            with console.status(case.__name__):
                results |= case()
        with console.status("memory"):
            results |= bench.memory(memory_messages)
    show("ROS 2", results, GOALS)
    return results


class Bench:
    """The measurements, in one simulator. dds: the module of the peer."""

    def __init__(self, dds: Any, live: LiveSimulator, settings: Ros2Settings, seconds: float) -> None:
        self._dds, self._live, self._settings, self._seconds = dds, live, settings, seconds

    def _node(self, *table: Channel) -> Ros2Node:
        return Ros2Node(self._live, list(table), (), self._settings)

    def _peer(self, *words: str) -> Any:
        return self._dds.fast_dds_peer(self._settings.domain_id, *words)

    def encode_and_write(self) -> dict[str, float]:
        """Return the CPU time of a message, encoded and written to one reader that receives all."""
        from ros2_tools import Peer
        from uwsim.bridges.ros2.graph import dds_name
        from uwsim.bridges.ros2.qos import writer_qos
        from uwsim.bridges.ros2.transport import DEPTH

        def write(writer: Any, message: Any) -> None:
            writer.write(encode(message))

        found = {}
        for kind in (SCAN, CLOUD, IMAGE):
            ours, calls = Peer(self._settings), []
            qos = writer_qos(DEPTH, latched=False, user_data=b"")
            writer = ours.participant.writer(dds_name("bench"), kind, qos)
            with self._peer(*self._dds.sub("bench", kind)) as other:
                self._dds.until(writer.readers)
                for k in range(200):  # as fast as possible, but only ten at a time, so that the reader keeps up
                    calls.append(spent_s(partial(write, writer, MESSAGES[kind]), time.thread_time))
                    time.sleep(0.1 if k % 10 == 9 else 0.0)
                other.wait_for("rt/bench", 1)
            ours.participant.close()
            found[f"{kind.rsplit('/', 1)[1]}: encode and write [us]"] = 1e6 * float(np.median(calls))
        return found

    def mixed(self) -> dict[str, float]:
        """Return the fraction of a core that 690 mixed messages per second use in addition to the simulator."""
        table = [channel(f"bench/{name}", kind, hz) for name, (kind, hz) in MIXED.items()]
        idle, _ = cores_used(lambda: time.sleep(self._seconds))
        words = [word for each in table for word in self._dds.sub(each.name, each.type)]
        with self._node(*table) as node, self._peer(*words) as other:
            for each in table:
                other.wait_for(f"rt/{each.name}", 2)
            before, began = sum(node.written.values()), time.monotonic()
            cores, _ = cores_used(lambda: time.sleep(self._seconds))
            rate = (sum(node.written.values()) - before) / (time.monotonic() - began)
        return {"mixed messages [1/s]": rate, "cores for them": cores - idle}

    def delivered(self) -> dict[str, float]:
        """Return the delivered share of scans at 40 Hz and clouds at 20 Hz, and a late reader's latched messages."""
        names = {"scan": SCAN, "cloud": CLOUD}
        static = Channel("static", TF, "out", "", delivery=Delivery(latched=True), read=lambda sim: MESSAGES[TF])
        found: dict[str, float] = {}
        for how in ("best_effort", "reliable"):
            with self._node(channel("scan", SCAN, 40.0), channel("cloud", CLOUD, 20.0), static) as node:
                with self._peer(
                    *(word for name, kind in names.items() for word in self._dds.sub(name, kind, how))
                ) as other:
                    for name in names:
                        other.wait_for(f"rt/{name}", 2)
                    start = {name: len(other.messages(f"rt/{name}")) for name in names}
                    before = dict(node.written)
                    time.sleep(self._seconds)
                    sent = {name: node.written[name] - before[name] for name in names}
                    time.sleep(0.5)
                    for name in names:
                        got = len(other.messages(f"rt/{name}")) - start[name]
                        found[f"{name}s delivered, {how}"] = min(got / sent[name], 1.0)
                with self._peer(*self._dds.sub("static", TF, "reliable", "latched")) as late:
                    found["latched messages that a late reader got"] = len(late.wait_for("rt/static", 1))
        return found

    def commanded(self) -> dict[str, float]:
        """Return the fraction of commands at 100 Hz that arrive."""
        came: list[float] = []
        commands = Channel("cmd_vel", TWIST, "in", "", apply=lambda live, message: came.append(message.linear.x))
        with self._node(commands), self._peer("pub", "rt/cmd_vel", "100"):
            self._dds.until(lambda: came)
            time.sleep(self._seconds)
            counts = np.round(1e3 * np.array(came)).astype(int)
        return {"/cmd_vel delivered": len(counts) / (counts[-1] - counts[0] + 1)}

    def stalled(self) -> dict[str, float]:
        """Return the longest write while a reader of 1 MB pictures is stopped."""
        from uwsim.bridges.ros2.dds import RawWriter

        plain, times_s = RawWriter.write, []

        def timed(self: RawWriter, cdr: memoryview) -> bool:
            began = time.monotonic()
            taken = plain(self, cdr)
            times_s.append(time.monotonic() - began)
            return taken

        with self._node(channel("picture", IMAGE, 20.0)) as node, self._peer(*self._dds.sub("picture", IMAGE)) as other:
            other.wait_for("rt/picture", 2)
            os.kill(other.process.pid, signal.SIGSTOP)
            RawWriter.write = timed  # type: ignore[method-assign]
            try:
                time.sleep(self._seconds)
                before, began = node.written["picture"], time.monotonic()
                time.sleep(1.0)
                rate = (node.written["picture"] - before) / (time.monotonic() - began)
            finally:
                RawWriter.write = plain  # type: ignore[method-assign]
                os.kill(other.process.pid, signal.SIGCONT)
        return {
            "longest write while a reader is stopped [ms]": 1e3 * max(times_s),
            "pictures written meanwhile [1/s]": rate,
        }

    def closing(self) -> dict[str, float]:
        """Return the time that closing takes while messages are sent, and the number of threads that remain."""
        before = threading.active_count()
        node = self._node(channel("scan", SCAN, 50.0))
        with self._peer(*self._dds.sub("scan", SCAN)) as other:
            other.wait_for("rt/scan", 2)
            began = time.monotonic()
            node.close()
            took_s = time.monotonic() - began
        return {"closing [s]": took_s, "threads left by the node": threading.active_count() - before}

    def memory(self, count: int) -> dict[str, float]:
        """Return the growth of memory over many scans, published as fast as possible to a reader in this process."""
        from ros2_tools import Peer

        sender, receiver = Peer(self._settings), Peer(self._settings)
        receiver.listen("bench", SCAN)
        writer = sender.writer("bench", SCAN)

        def flow(messages: int) -> float:
            for k in range(messages):
                writer.write(encode(MESSAGES[SCAN]))
                if k % 50 == 0:
                    receiver.heard("bench")
            self._dds.until(lambda: not receiver.heard("bench"))
            return resident_mb()

        before = flow(count // 10)
        grown = flow(count) - before
        for side in (sender, receiver):
            side.participant.close()
        return {"memory of the further messages [MB]": grown}
