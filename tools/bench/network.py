"""The load that the rosbridge supports and its cost: many subscribers, some that do not read, and maximum throughput.

The simulator runs in real time on the lake; its channels here are one true ping of 1,025 beams at 50 Hz and one true
picture (JPEG) at 10 Hz. Latency is measured from the reading on the simulator's thread to the decoded message in
another process, the simulator's lateness (the worst delay of a step) with and without 50 clients that have stopped
reading until their queues are full. For the throughput, limits are raised where one client relays to another; a bare
WebSocket server sends the same bytes without any protocol.
"""

from __future__ import annotations

import asyncio
import json
import socket
import sys
import time
from contextlib import suppress
from typing import Annotated, Any
from urllib.parse import urlsplit

import cbor2
import numpy as np
import orjson
import typer
from _harness import (
    PICTURE,
    SCAN,
    SWITCH_S,
    child,
    console,
    cores_used,
    ended,
    new_table,
    percentiles,
    result_of,
    show,
    stamped,
    true_messages,
    wait_for,
)
from websockets.asyncio.client import ClientConnection, connect
from websockets.asyncio.server import serve
from websockets.exceptions import ConnectionClosed

from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge.encoding import Sample
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels import Channel
from uwsim.channels.ros.messages import default_message, to_plain
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

ASLEEP_S = 45.0
FILLED_S = 120.0  # time limit for filling the queues of clients that do not read
UNLIMITED = Limits(messages_per_s=1e9, bytes_per_s=1e12, work_share=1.0)


def main(
    seconds: Annotated[float, typer.Option(min=0.5, help="Length of each measurement [s].")] = 5.0,
    stalled: Annotated[float, typer.Option(min=0.5, help="Length of those of the steps' lateness [s].")] = 30.0,
) -> dict[str, Any]:
    """Measure all cases in turn and print the results."""
    sys.setswitchinterval(SWITCH_S)
    sim = Simulator("lake", sonar_model=4)
    scan, picture = true_messages(sim)
    rows, flat = [], {}
    for readers, sleepers, length in ((0, 0, seconds), (1, 0, seconds), (10, 0, seconds), (50, 0, seconds),
                                      (10, 0, stalled), (10, 50, stalled)):  # fmt: skip
        with console.status(f"{readers} subscribers, {sleepers} that do not read"):
            rows.append(load(sim, scan, picture, readers, sleepers, length))
    sources = {"simulator": (flat_out, ("cbor", "cbor-raw", "none")), "client": (relay, ("cbor", "none"))}
    for source, (measure, encodings) in sources.items():
        for encoding in encodings:
            with console.status(f"flat out from a {source}, {encoding}"):
                found, cpu_us = measure(scan, encoding, seconds)
            flat[f"{source}, {encoding}: scans/s"] = found["messages_per_s"]
            flat[f"{source}, {encoding}: server's CPU [us/scan]"] = cpu_us
    flat["bare: scans/s"] = asyncio.run(bare(scan, seconds))["messages_per_s"]
    title = "in real time, CBOR: scans at 50 Hz, pictures at 10 Hz; latency and the latest step in ms"
    table = new_table(title, *rows[0], texts=0)
    for row in rows:
        table.add_row(*(f"{value:.4g}" for value in row.values()))
    console.print(table)
    show("flat out to one subscriber", flat, {"simulator, cbor: scans/s": ">= 5000"})
    return {"load": rows, "flat_out": flat}


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
            cores, found = cores_used(lambda: result_of(crowd) if crowd else time.sleep(seconds))
            lost = sum(session.outbox.lost for session in server.sessions.values())
            if lazy is not None:
                ended(lazy)
            found = found or {"messages_per_s": 0.0, **percentiles([], 50, 99)}
            return {
                "read": subscribers, "sleep": sleepers, "msg/s": found["messages_per_s"], "p50": found["p50"],
                "p99": found["p99"], "cores": cores, "lost": lost, "full": before, "s": seconds, "pace": live.factor,
                "late": 1e3 * live.lateness,
            }  # fmt: skip


def full(server: RosbridgeServer) -> int:
    """Return the number of clients that have lost messages because of full queues."""
    return sum(session.outbox.lost > 0 for session in list(server.sessions.values()))


def counted(server: RosbridgeServer, compression: str, seconds: float) -> Any:
    """Return the process of a subscriber that counts scans, when the server knows it."""
    process = child(__file__, server.url, compression, 1, seconds, "count")
    wait_for(lambda: server.graph.topics.get("scan") is not None and server.graph.topics["scan"].sinks)
    return process


def relay(scan: Any, compression: str, seconds: float) -> tuple[dict[str, Any], float]:
    """Have one client publish scans to another as fast as the server relays them."""
    with RosbridgeServer(None, limits=UNLIMITED) as server:
        source = child(__file__, server.url, compression, 1, seconds + 10.0, "publish")
        try:
            wait_for(lambda: "scan" in server.graph.topics)
            process = counted(server, compression, seconds)
            cores, found = cores_used(lambda: result_of(process))
        finally:
            ended(source)
        return found, 1e6 * cores * seconds / max(found["messages"], 1)


def flat_out(scan: Any, compression: str, seconds: float) -> tuple[dict[str, Any], float]:
    """Publish scans as fast as one subscriber reads them; each is encoded separately."""
    with RosbridgeServer(None) as server:
        process = counted(server, compression, seconds)
        cpu_s = time.process_time()
        pump = asyncio.run_coroutine_threadsafe(publish_on(server, scan), server._listener.loop)
        found = result_of(process)
        cpu_s = time.process_time() - cpu_s
        pump.cancel()
        return found, 1e6 * cpu_s / max(found["messages"], 1)


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


async def publish(url: str, compression: str, seconds: float) -> None:
    """Publish a scan of 1,025 beams repeatedly, each as soon as the connection accepts it."""
    scan = default_message(SCAN)
    scan.ranges = np.linspace(5.0, 50.0, 1025, dtype=np.float32)
    is_text = compression == "none"
    operation = {"op": "publish", "topic": "/scan", "msg": to_plain(scan, 1, "json" if is_text else "cbor")}
    json_text = orjson.dumps(operation, option=orjson.OPT_SERIALIZE_NUMPY).decode() if is_text else ""
    frame = json_text or cbor2.dumps(operation)
    deadline_s = time.monotonic() + seconds
    async with connect(url, compression=None, max_size=None) as connection:
        await connection.send(json.dumps({"op": "advertise", "topic": "/scan", "type": SCAN.replace("/msg", "")}))
        while time.monotonic() < deadline_s:
            await connection.send(frame)


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
                if time.monotonic() > deadline_s:
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
    return {"messages": messages, "messages_per_s": messages / seconds, **percentiles(latencies_ms, 50, 99)}


if __name__ == "__main__":
    url, compression, count, seconds, mode = sys.argv[1:]
    if mode == "publish":
        asyncio.run(publish(url, compression, float(seconds)))
    else:
        print(json.dumps(asyncio.run(subscribe(url, compression, int(count), float(seconds), mode))))
