"""The load that the rosbridge supports and its cost: many subscribers, some that do not read, and maximum throughput.

The simulator runs in real time on the lake; its channels here are one true ping of 1,025 beams at 50 Hz and one true
picture (JPEG) at 10 Hz, captured at the start, so that the network is measured and not the sonar. Subscribers run in
another process; latency is measured from the reading on the simulator's thread to the decoded message. The simulator's
lateness (the worst delay of a step) is measured for half a minute, with and without 50 clients that have stopped
reading until their queues are full. For the throughput, scans go from the server to a client, and from one client to
another, with raised limits; a bare WebSocket server that sends the same bytes without any protocol is measured in the
same run.
"""

from __future__ import annotations

import asyncio
import json
import os
import socket
import sys
import time
from contextlib import suppress
from typing import Annotated, Any, Literal
from urllib.parse import urlsplit

import cbor2
import numpy as np
import orjson
import typer
from _harness import child, console, new_table, result_of, wait_for
from rich.table import Table
from websockets.asyncio.client import ClientConnection, connect
from websockets.asyncio.server import serve
from websockets.exceptions import ConnectionClosed

from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge.encoding import Sample
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels import Channel, channels
from uwsim.channels.ros.messages import default_message, to_plain
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

SCAN, PICTURE = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/CompressedImage"
GOALS = {"scans_per_s": 5000.0}
SWITCH_S = 0.0005  # as uwsim serve sets it
ASLEEP_S = 45.0
FILLED_S = 120.0  # time limit for filling the queues of clients that do not read
UNLIMITED = Limits(messages_per_s=1e9, bytes_per_s=1e12, work_share=1.0)
JSON = orjson.OPT_SERIALIZE_NUMPY


def main(
    seconds: Annotated[float, typer.Option(min=0.5, help="Length of each measurement [s].")] = 5.0,
    stalled: Annotated[float, typer.Option(min=0.5, help="Length of those of the steps' lateness [s].")] = 30.0,
) -> dict[str, Any]:
    """Measure all cases in turn and print the results."""
    sys.setswitchinterval(SWITCH_S)
    sim = Simulator("lake", sonar_model=4)
    scan, picture = true_messages(sim)
    results: dict[str, Any] = {"load": [], "flat_out": {}, "machine_load": os.getloadavg()}
    cases = [(0, 0, seconds), (1, 0, seconds), (10, 0, seconds), (50, 0, seconds), (10, 0, stalled), (10, 50, stalled)]
    for subscribers, sleepers, length in cases:
        with console.status(f"{subscribers} subscribers, {sleepers} that do not read"):
            results["load"].append(load(sim, scan, picture, subscribers, sleepers, length))
    for name in ("cbor", "cbor-raw", "none"):
        with console.status(f"flat out, {name}"):
            results["flat_out"][name] = flat_out(scan, name, seconds)
    for name in ("cbor", "none"):
        with console.status(f"relayed, {name}"):
            results["flat_out"][f"relay {name}"] = relay(scan, name, seconds)
    with console.status("flat out, bare"):
        results["flat_out"]["bare"] = asyncio.run(bare(scan, seconds))
    console.print(load_table(results["load"]))
    console.print(flat_out_table(results["flat_out"]))
    return results


def true_messages(sim: Simulator) -> tuple[Any, Any]:
    """Return one scan and one picture from the simulator's own channels."""
    table = {channel.name: channel for channel in channels(sim)}
    camera = next(channel for channel in table.values() if channel.type == PICTURE)
    scan, picture = table["scan"].read(sim), None
    while picture is None:
        picture = camera.read(sim)
        sim.advance(0.1)
    return scan, picture


def stamped(message: Any) -> Any:
    """Return the message stamped with the wall-clock time, from which latency is measured."""
    copy = default_message(message.__msgtype__)
    for name in vars(message):
        setattr(copy, name, getattr(message, name))
    copy.header = default_message("std_msgs/msg/Header")
    copy.header.stamp.sec, copy.header.stamp.nanosec = divmod(time.monotonic_ns(), 10**9)
    return copy


def load(sim: Simulator, scan: Any, picture: Any, subscribers: int, sleepers: int, seconds: float) -> dict[str, Any]:
    """Run in real time with subscribers to both topics; return the messages received and the cost."""
    with LiveSimulator(sim, speed=1.0) as live:
        server = RosbridgeServer(live)
        server.channels = [
            Channel("scan", SCAN, "out", "", rate_hz=50.0, read=lambda sim: stamped(scan)),
            Channel("picture", PICTURE, "out", "", rate_hz=10.0, read=lambda sim: stamped(picture)),
        ]
        with server:
            lazy = child(__file__, server.url, "cbor", sleepers, seconds + 3 * FILLED_S, "sleep") if sleepers else None
            wait_for(lambda: full(server) == sleepers, FILLED_S)
            crowd = child(__file__, server.url, "cbor", subscribers, seconds, "read") if subscribers else None
            wait_for(lambda: len(server.sessions) == subscribers + sleepers)
            time.sleep(0.5)
            before = full(server)
            live.forget_delays()
            cpu_s, wall_s = time.process_time(), time.perf_counter()
            found = result_of(crowd) if crowd else time.sleep(seconds) or {}
            cpu_s, wall_s = time.process_time() - cpu_s, time.perf_counter() - wall_s
            lost = sum(session.outbox.lost for session in server.sessions.values())
            if lazy is not None:
                lazy.kill()
                lazy.communicate()
            return {
                "subscribers": subscribers,
                "sleepers": sleepers,
                "factor": live.factor,
                "lateness_ms": 1e3 * live.lateness,
                "cpu_share": cpu_s / wall_s,
                "full": before,
                "seconds": seconds,
                "lost": lost,
                **found,
            }


def full(server: RosbridgeServer) -> int:
    """Return the number of clients that have lost messages because of full queues."""
    return sum(session.outbox.lost > 0 for session in list(server.sessions.values()))


def relay(scan: Any, compression: str, seconds: float) -> dict[str, Any]:
    """Have one client publish scans to another as fast as the server relays them."""
    with RosbridgeServer(None, limits=UNLIMITED) as server:
        source = child(__file__, server.url, compression, 1, seconds + 10.0, "publish")
        try:
            wait_for(lambda: "scan" in server.graph.topics)
            process = child(__file__, server.url, compression, 1, seconds, "count")
            wait_for(lambda: server.graph.topics["scan"].sinks)
            cpu_s, began_s = time.process_time(), time.perf_counter()
            found = result_of(process)
            cpu_s, wall_s = time.process_time() - cpu_s, time.perf_counter() - began_s
        finally:
            source.kill()
            source.communicate()
        return {**found, "cpu_us": 1e6 * cpu_s * (seconds / wall_s) / max(found["messages"], 1)}


def flat_out(scan: Any, compression: str, seconds: float) -> dict[str, Any]:
    """Publish scans as fast as one subscriber reads them; each is encoded separately."""
    with RosbridgeServer(None) as server:
        process = child(__file__, server.url, compression, 1, seconds, "count")
        wait_for(lambda: server.graph.topics.get("scan") is not None and server.graph.topics["scan"].sinks)
        cpu_s = time.process_time()
        pump = asyncio.run_coroutine_threadsafe(publish_on(server, scan), server._listener.loop)
        found = result_of(process)
        cpu_s = time.process_time() - cpu_s
        pump.cancel()
        return {**found, "cpu_us": 1e6 * cpu_s / max(found["messages"], 1)}


async def publish_on(server: RosbridgeServer, scan: Any) -> None:
    """Keep the subscriber's queue filled, on the server's own loop."""
    topic = server.graph.topics["scan"]
    while server.sessions:
        (session,) = server.sessions.values()
        for mailbox in list(session.outbox._mailboxes.values()):
            for _ in range(90 - len(mailbox.samples)):
                server.graph.publish(topic, Sample(scan))
        await asyncio.sleep(0)


async def bare(scan: Any, seconds: float) -> dict[str, Any]:
    """Send the same scan, encoded once, using only `websockets`."""
    frame = cbor2.dumps({"op": "publish", "topic": "/scan", "msg": to_plain(scan, 1, "cbor")})

    async def send(connection: Any) -> None:
        with suppress(ConnectionClosed):
            while True:
                await connection.send(frame)

    async with serve(send, "127.0.0.1", 0, compression=None) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        process = child(__file__, f"ws://127.0.0.1:{port}", "cbor", 1, seconds, "count")
        return await asyncio.to_thread(result_of, process)


async def publish(url: str, compression: str, seconds: float) -> dict[str, Any]:
    """Publish a scan of 1,025 beams repeatedly, each as soon as the connection accepts it."""
    scan = default_message(SCAN)
    scan.ranges = np.linspace(5.0, 50.0, 1025, dtype=np.float32)
    form: Literal["json", "cbor"] = "json" if compression == "none" else "cbor"
    operation = {"op": "publish", "topic": "/scan", "msg": to_plain(scan, 1, form)}
    frame = cbor2.dumps(operation) if form == "cbor" else orjson.dumps(operation, option=JSON).decode()
    messages, deadline_s = 0, time.monotonic() + seconds
    async with connect(url, compression=None, max_size=None) as connection:
        await connection.send(json.dumps({"op": "advertise", "topic": "/scan", "type": SCAN.replace("/msg", "")}))
        while time.monotonic() < deadline_s:
            await connection.send(frame)
            messages += 1
    return {"messages": messages}


def slow_socket(url: str) -> socket.socket:
    """Return a connection with a small receive buffer, so that unread data wait at the sender."""
    place = urlsplit(url)
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.connect((place.hostname, place.port))
    return connection


async def subscribe(url: str, compression: str, count: int, seconds: float, mode: str) -> dict[str, Any]:
    """Subscribe with `count` clients, which decode messages ("read"), count them ("count") or read none ("sleep")."""
    latencies_ms: list[float] = []
    messages = 0

    async def one() -> None:
        nonlocal messages
        async with connect(url, compression=None, max_size=None) as connection:
            await ask(connection)
            await connection.recv()
            deadline_s = time.monotonic() + seconds
            async for frame in connection:
                now_s = time.monotonic()
                if now_s > deadline_s:
                    return
                messages += 1
                if mode == "read":
                    stamp = cbor2.loads(frame)["msg"]["header"]["stamp"]
                    latencies_ms.append(1e3 * (time.monotonic() - stamp["sec"] - 1e-9 * stamp["nanosec"]))

    async def ask(connection: ClientConnection) -> None:
        for topic, kind in (("/scan", SCAN), ("/picture", PICTURE))[: 1 if mode == "count" else 2]:
            operation = {"op": "subscribe", "topic": topic, "type": kind, "compression": compression}
            await connection.send(json.dumps(operation | ({"queue_length": 100} if mode == "count" else {})))

    async def sleep() -> None:
        deadline_s = time.monotonic() + seconds
        while time.monotonic() < deadline_s:  # the server drops a client that has not answered for a minute
            async with connect(url, compression=None, max_queue=1, sock=slow_socket(url)) as connection:
                await ask(connection)
                await asyncio.sleep(min(ASLEEP_S, seconds))
                connection.transport.abort()

    await asyncio.gather(*(sleep() if mode == "sleep" else one() for _ in range(count)))
    found: dict[str, Any] = {"messages": messages, "messages_per_s": messages / seconds}
    if latencies_ms:
        found["latency_ms"] = {f"p{p}": float(np.percentile(latencies_ms, p)) for p in (50, 99)}
    return found


def load_table(cases: list[dict[str, Any]]) -> Table:
    """Return the table of cases in real time."""
    title = "in real time, CBOR: scans at 50 Hz, pictures at 10 Hz; latency and the latest step in ms"
    columns = ("read", "sleep", "msg/s", "p50", "p99", "cores", "lost", "full", "s", "pace", "late")
    table = new_table(title, *columns, texts=0)
    for case in cases:
        latency = case.get("latency_ms")
        table.add_row(
            str(case["subscribers"]),
            str(case["sleepers"]),
            f"{case.get('messages_per_s', 0.0):.0f}",
            *([f"{latency[p]:.2f}" for p in ("p50", "p99")] if latency else ["-", "-"]),
            f"{case['cpu_share']:.2f}",
            str(case["lost"]),
            str(case["full"]),
            f"{case['seconds']:g}",
            f"{case['factor']:.3f}",
            f"{case['lateness_ms']:.1f}",
        )
    return table


def flat_out_table(cases: dict[str, dict[str, Any]]) -> Table:
    """Return the table of maximum throughput."""
    title = f"flat out to one subscriber (goal: {GOALS['scans_per_s']:.0f} scans/s by CBOR)"
    table = new_table(title, "encoding", "scans/s", "server's CPU [us/scan]", "of bare", texts=0)
    for name, case in cases.items():
        share = case["messages_per_s"] / cases["bare"]["messages_per_s"]
        cost = f"{case['cpu_us']:.0f}" if "cpu_us" in case else "-"
        table.add_row(name.replace("none", "json"), f"{case['messages_per_s']:.0f}", cost, f"{share:.2f}")
    return table


if __name__ == "__main__":
    url, compression, count, seconds, mode = sys.argv[1:]
    if mode == "publish":
        print(json.dumps(asyncio.run(publish(url, compression, float(seconds)))))
    else:
        print(json.dumps(asyncio.run(subscribe(url, compression, int(count), float(seconds), mode))))
