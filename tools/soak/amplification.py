"""The cost of a client's frames to a rosbridge: memory and the network thread's time, for one attack at a time.

    .venv/bin/python tools/soak/amplification.py [NAME ...]

Each attack comes from a separate process against a new server. One line per attack reports the peak growth of resident
memory, the growth that remained after all clients had left, and the longest time for which the network thread missed a
2 ms timer, by the wall clock, which includes time that other processes used.
"""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from threading import Thread

import cbor2
from steady import peak_mb, resident_mb
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from uwsim.bridges import RosbridgeServer
from uwsim.cli.run_live import keep_threads_moving

SIZE = (2 << 20) - 200  # of a large frame's content
BEAT_S = 0.002
PATIENCE_S = 60.0
OPTIONS = {"compression": None, "max_size": None, "ping_interval": None, "close_timeout": 0.1}


def publishes(kind: str, field: str, element: str, size: int = SIZE) -> list[str | bytes]:
    """Publish a list with as many elements as fit in a frame."""
    elements = ",".join([element] * (size // (len(element) + 1)))
    return [advertise(0, kind), f'{{"op":"publish","topic":"/t0","msg":{{"{field}":[{elements}]}}}}']


def advertise(number: int, kind: str = "std_msgs/String", **more: object) -> str:
    """Advertise a topic."""
    return json.dumps({"op": "advertise", "topic": f"/t{number}", "type": kind, **more})


ONCE: dict[str, Callable[[], list[str | bytes]]] = {
    "no frame": list,
    "empty markers, 2 MB": lambda: publishes("visualization_msgs/MarkerArray", "markers", "{}"),
    "empty markers, 50 kB": lambda: publishes("visualization_msgs/MarkerArray", "markers", "{}", 50_000),
    "empty names, 2 MB": lambda: publishes("sensor_msgs/JointState", "name", '""'),
    "CBOR of empty lists, 2 MB": lambda: [cbor2.dumps({"a": [[]] * 2_000_000})],
    "bytes as a list, 2 MB": lambda: publishes("std_msgs/UInt8MultiArray", "data", "255"),
}
"""Frames of one client, while others subscribe with each compression."""


@contextmanager
def connected(url: str, count: int = 1, **options: int) -> Iterator[list[ClientConnection]]:
    """Connect clients."""
    with ExitStack() as stack:
        yield [stack.enter_context(connect(url, **OPTIONS, **options)) for _ in range(count)]


def flood(url: str, count: int, frame: Callable[[int], str], first: list[str]) -> None:
    """Send the frames of `first`, and then frame(0) to frame(count - 1)."""
    with suppress(ConnectionClosed), connected(url) as (client,):
        for operation in [*first, *map(frame, range(count))]:
            client.send(operation)
        settle(client)


def settle(client: ClientConnection) -> None:
    """Return when the server has processed everything that was sent; print what it refused."""
    client.send('{"op":"call_service","service":"/rosapi/get_time","id":"last"}')
    while (answer := json.loads(client.recv(PATIENCE_S))).get("id") != "last":
        if answer["op"] == "status":
            print(f"    refused: {answer['msg'][:150]}")


def published(number: int) -> str:
    """Publish 2 MB on a topic."""
    return f'{{"op":"publish","topic":"/t{number}","msg":{{"data":"{"x" * SIZE}"}}}}'


def once(url: str, name: str) -> None:
    """Send one attack's frames while another client subscribes with each compression."""
    with connected(url, 4) as (client, *readers):
        for reader, compression in zip(readers, ("none", "cbor", "png"), strict=True):
            reader.send(json.dumps({"op": "subscribe", "topic": "/t0", "compression": compression}))
            Thread(target=list, args=(reader,), daemon=True).start()
        for frame in ONCE[name]():
            client.send(frame)
        settle(client)
        time.sleep(1.0)


def slow_reader(url: str) -> None:
    """Subscribe to 20 topics, each of which carries ten messages of 2 MB, and do not read."""
    with connected(url, max_queue=1) as (reader,):
        for k in range(20):
            reader.send(json.dumps({"op": "subscribe", "topic": f"/t{k}", "type": "std_msgs/String"}))
        flood(url, 200, lambda k: published(k % 20), [advertise(k) for k in range(20)])
        time.sleep(2.0)


def latched(url: str) -> None:
    """Latch 2 MB on each of 100 topics."""
    flood(url, 100, published, [advertise(k, latch=True) for k in range(100)])


def unanswered(url: str) -> None:
    """Call a service that never answers, 100 times with 2 MB."""
    with connected(url, max_queue=1) as (server,):
        server.send('{"op":"advertise_service","service":"/never","type":"demo/Never"}')
        time.sleep(0.5)
        call = '{{"op":"call_service","service":"/never","id":"{}","args":{{"a":"{}"}}}}'
        flood(url, 100, lambda k: call.format(k, "x" * SIZE), [])


LONG: dict[str, Callable[[str], None]] = {
    "a reader of 20 topics of 2 MB that does not read": slow_reader,
    "2 MB latched on 100 topics": latched,
    "100 unanswered calls of 2 MB": unanswered,
}


async def beat(worst_s: list[float]) -> None:
    """Keep the longest time by which a timer was missed."""
    while True:
        begun_s = time.monotonic()
        await asyncio.sleep(BEAT_S)
        worst_s[0] = max(worst_s[0], time.monotonic() - begun_s - BEAT_S)


def serve(name: str) -> None:
    """Run the server for one attack."""
    with RosbridgeServer(None) as server:
        with connect(server.url) as client:
            settle(client)
        keep_threads_moving()
        first_mb, worst_s = resident_mb(), [0.0]
        Path("/proc/self/clear_refs").write_text("5")  # resets the recorded peak
        beating = asyncio.run_coroutine_threadsafe(beat(worst_s), server._listener.loop)
        attack = subprocess.run([sys.executable, __file__, "--attack", server.url, name], timeout=600)
        time.sleep(1.0)
        beating.cancel()
        time.sleep(1.0)
        print(
            f"{name}: {first_mb:.0f} MB, at most +{peak_mb() - first_mb:.0f}, at the end "
            f"+{resident_mb() - first_mb:.0f}; held for {1e3 * worst_s[0]:.0f} ms; {len(server.sessions)} sessions left"
            + ("" if attack.returncode == 0 else "; the attack failed"),
            flush=True,
        )


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--attack", url, name]:
            try:
                once(url, name) if name in ONCE else LONG[name](url)
            except TimeoutError:
                print(f"    no answer within {PATIENCE_S:g} s")
        case ["--serve", name]:
            serve(name)
        case names:
            for name in names or [*ONCE, *LONG]:
                subprocess.run([sys.executable, __file__, "--serve", name], check=True)
