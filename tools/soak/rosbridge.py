"""Soak test: hostile clients at a live rosbridge for ten minutes. Memory, sessions and pace must end as they began.

    .venv/bin/python tools/soak/rosbridge.py [SECONDS]

Clients connect in waves of up to 1,000, send garbage, valid and damaged operations, floods, unfinished fragments and
huge frames, subscribe without reading, and leave at any time. One line is printed after each minute: resident memory,
Python's objects in use, sessions, topics, and the simulator's pace.

A first wave precedes the first memory measurement, since the allocator keeps and reuses the memory of the largest
number of clients so far, about 15 MB. The exit code is 1 if, after that, memory grew by more than 16 MB or objects in
use by more than 1 %, or if anything was left behind.
"""

from __future__ import annotations

import asyncio
import json
import random
import subprocess
import sys
import time

import cbor2
from steady import resident_mb  # in this folder
from websockets.asyncio.client import connect

from uwsim.bridges import RosbridgeServer
from uwsim.cli.run_live import keep_threads_moving
from uwsim.live import LiveSimulator

GROWTH_MB = 16.0
GROWTH_OBJECTS = 0.01  # a few thousand freed tuples are kept for reuse
SETTLE_S = 5.0
CROWD = 40
WAVE = 1000
OPS = (
    "advertise", "unadvertise", "publish", "subscribe", "unsubscribe", "call_service", "advertise_service",
    "unadvertise_service", "service_response", "fragment", "set_level", "status",
)  # fmt: skip
TOPICS = ("/scan", "/tf", "/odom", "/key", "/chatter", "/octomap_binary", "/camera/front/image_raw/compressed")
TYPES = ("std_msgs/String", "sensor_msgs/LaserScan", "geometry_msgs/Pose", "nonsense")


def operation(rng: random.Random) -> dict[str, object]:
    """Return an operation that may be valid."""
    fields: dict[str, object] = {"op": rng.choice(OPS), "topic": rng.choice(TOPICS), "type": rng.choice(TYPES)}
    fields |= {"id": str(rng.randrange(20)), "service": rng.choice(("/rosapi/topics", "/own", "/nobody"))}
    fields |= {"msg": {"data": "x" * rng.randrange(2000)}, "args": {"a": [rng.random()] * rng.randrange(50)}}
    fields |= {"data": "x" * rng.randrange(5000), "num": rng.randrange(3), "total": rng.randrange(1, 4)}
    fields |= {"compression": rng.choice(("none", "cbor", "cbor-raw", "png")), "queue_length": rng.randrange(3)}
    return {key: value for key, value in fields.items() if key == "op" or rng.random() < 0.8}


def frame(rng: random.Random) -> str | bytes:
    """Return a frame: valid, damaged, or garbage."""
    kind = rng.randrange(8)
    if kind == 0:
        return rng.randbytes(rng.randrange(3000))
    if kind == 1:
        return '{"op":' + "[" * rng.randrange(2000)
    if kind == 2:
        return "x" * rng.choice((10, 100_000, 3_000_000))
    data = cbor2.dumps(operation(rng)) if kind < 5 else json.dumps(operation(rng)).encode()
    if rng.random() < 0.3:
        data = data[: rng.randrange(len(data))] + rng.randbytes(3)
    return data if kind < 5 else data.decode(errors="replace")


async def attack(url: str, rng: random.Random) -> None:
    """Run one hostile client for a short time."""
    try:
        async with connect(url, compression=None, max_queue=1, close_timeout=0.1, open_timeout=20) as connection:
            for _ in range(rng.randrange(60)):
                await asyncio.wait_for(connection.send(frame(rng)), 2.0)
                if rng.random() < 0.3:
                    await asyncio.sleep(rng.random() * 0.05)
            if rng.random() < 0.3:
                await asyncio.sleep(rng.random() * 3.0)  # without reading
            if rng.random() < 0.5:
                connection.transport.abort()
    except Exception:  # any error that ends a hostile client is fine
        pass


async def besiege(url: str, until_s: float, seed: int) -> None:
    """Maintain a crowd of hostile clients, with an occasional wave."""
    rng = random.Random(seed)
    while time.monotonic() < until_s:
        count = WAVE if rng.random() < 0.02 else CROWD
        await asyncio.gather(*(attack(url, random.Random(rng.random())) for _ in range(count)))


async def wave(url: str) -> None:
    """Connect 1,000 hostile clients at once."""
    await asyncio.gather(*(attack(url, random.Random(seed)) for seed in range(WAVE)))


def main() -> int:
    """Run; return the exit code."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 600.0
    keep_threads_moving()
    with LiveSimulator("lake") as live, RosbridgeServer(live) as server:
        topics = len(server.graph.topics)
        # In separate processes, since here they would compete with the simulator for the interpreter.
        subprocess.run([sys.executable, __file__, "--wave", server.url], check=True)
        first_mb, first_objects = settled()
        print(f"after the first wave: {first_mb:.0f} MB, {first_objects} objects", flush=True)
        said_s = start_s = time.monotonic()
        siege = subprocess.Popen([sys.executable, __file__, "--siege", server.url, str(seconds)])
        while siege.poll() is None:
            time.sleep(1.0)
            if time.monotonic() - said_s >= min(60.0, seconds / 4):
                said_s = time.monotonic()
                print(
                    f"{said_s - start_s:5.0f} s: {resident_mb():.0f} MB, {sys.getallocatedblocks()} objects, "
                    f"{len(server.sessions)} sessions, "
                    f"{len(server.graph.topics)} topics, pace {live.factor:.3f}, late {1e3 * live.lateness:.1f} ms",
                    flush=True,
                )
                live.forget_delays()  # each line reports the worst delay of its own minute
        last_mb, last_objects = settled()
        grown_mb, grown = last_mb - first_mb, last_objects / first_objects - 1.0
        left = len(server.sessions), len(server.graph.topics) - topics
        print(
            f"end: {last_mb:.0f} MB, grown by {grown_mb:.0f}; objects by {grown:.2%}; sessions and topics left: {left}"
        )
        failed = grown_mb > GROWTH_MB or grown > GROWTH_OBJECTS or left != (0, 0) or live.error is not None
        return int(failed)


def settled() -> tuple[float, int]:
    """Return memory [MB] and objects in use, some seconds after the last client has left."""
    time.sleep(SETTLE_S)
    return resident_mb(), sys.getallocatedblocks()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--wave"]:
        asyncio.run(wave(sys.argv[2]))
    elif sys.argv[1:2] == ["--siege"]:
        asyncio.run(besiege(sys.argv[2], time.monotonic() + float(sys.argv[3]), 1))
    else:
        sys.exit(main())
