"""The clients of a rosbridge in a soak test: a first wave of hostile ones, then a crowd of them beside ordinary ones.

    python tools/soak/clients.py URL SECONDS

Hostile clients send garbage, valid and damaged operations, floods, unfinished fragments and huge frames, subscribe
without reading, and leave at any time. Ordinary ones read and steer, come and go, or stop reading. They are in a
process of their own, since in the server's they would compete with the simulator for the interpreter. A line is printed
when the first wave, the largest number of clients at once, has gone.
"""

from __future__ import annotations

import asyncio
import json
import random
import sys
from contextlib import suppress
from typing import Any

import cbor2
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

CROWD, WAVE = 40, 1000
OPS = (
    "advertise", "unadvertise", "publish", "subscribe", "unsubscribe", "call_service", "advertise_service",
    "unadvertise_service", "service_response", "fragment", "set_level", "status",
)  # fmt: skip
TOPICS = ("/scan", "/tf", "/odom", "/key", "/chatter", "/octomap_binary", "/camera/front/image_raw/compressed")
TYPES = ("std_msgs/String", "sensor_msgs/LaserScan", "geometry_msgs/Pose", "nonsense")
PICTURES = ("/camera/front/image_raw/compressed", "/images/compressed", "/forward_looking/picture/compressed")
CLOUDS = ("/points", "/laserPointCloud", "/octomap_binary", "/scan")
TELEMETRY = ("/telemetry", "/odom", "/imu", "/tf", "/battery_state", "/diagnostics")
PICTURE_MS, CLOUD_MS = 2000, 500  # minimum interval between two messages


def operation(rng: random.Random) -> dict[str, object]:
    """Return an operation that may be valid."""
    fields: dict[str, object] = {"op": rng.choice(OPS), "topic": rng.choice(TOPICS), "type": rng.choice(TYPES)}
    fields |= {"id": str(rng.randrange(20)), "service": rng.choice(("/rosapi/topics", "/own", "/no_such"))}
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


async def besiege(url: str, rng: random.Random) -> None:
    """Connect a crowd of hostile clients, occasionally a wave of them."""
    count = WAVE if rng.random() < 0.02 else CROWD
    await asyncio.gather(*(attack(url, random.Random(rng.random())) for _ in range(count)))


async def connected(url: str, **options: Any) -> ClientConnection:
    """Return a connection that accepts large messages."""
    return await connect(
        url, **{"compression": None, "max_size": None, "open_timeout": 60, "close_timeout": 1, **options}
    )


async def send(connection: ClientConnection, **fields: Any) -> None:
    """Send an operation."""
    await connection.send(json.dumps(fields))


async def subscribe(connection: ClientConnection, topics: tuple[str, ...], every_ms: int = 0) -> None:
    """Subscribe to topics."""
    for topic in topics:
        await send(connection, op="subscribe", topic=topic, throttle_rate=every_ms, queue_length=1, compression="cbor")


async def read(url: str, topics: tuple[str, ...], every_ms: int = 0) -> None:
    """Subscribe, and read until the connection ends."""
    connection = await connected(url)
    await subscribe(connection, topics, every_ms)
    async for _ in connection:
        pass


async def steer(url: str) -> None:
    """Undock the vehicle, and turn it on the spot, to and fro, for two seconds out of every twenty.

    The turns are short because the velocity control loop sends 20 commands per second, which stay in the log.
    """

    async def listen(seconds: float) -> None:
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while True:
                    await connection.recv()

    connection = await connected(url)
    await send(connection, op="subscribe", topic="/odom", throttle_rate=1000)
    turn = 0.2
    while True:
        await send(connection, op="call_service", service="/undock", args={})
        await send(connection, op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.1}, "angular": {"z": turn}})
        await listen(2.0)
        await send(connection, op="publish", topic="/cmd_wrench", msg={"torque": {"z": turn}})
        await listen(18.0)
        turn = -turn


async def come_and_vanish(url: str, rng: random.Random) -> None:
    """Subscribe to random topics, and leave without closing the connection."""
    while True:
        connection = await connected(url)
        await subscribe(connection, (rng.choice(PICTURES), rng.choice(CLOUDS), rng.choice(TELEMETRY)), 200)
        await asyncio.sleep(rng.uniform(0.0, 4.0))
        connection.transport.abort()
        await asyncio.sleep(rng.uniform(0.0, 2.0))


async def stop_reading(url: str) -> None:
    """Subscribe to all large topics and read nothing for a minute; then reconnect."""
    while True:
        connection = await connected(url, max_queue=1, ping_interval=None)
        await subscribe(connection, CLOUDS + PICTURES[:1], 1000)
        await asyncio.sleep(60.0)
        connection.transport.abort()


async def again(client: Any, *arguments: Any) -> None:
    """Run a client, and restart it whenever it has ended, as when the server has closed its connection."""
    while True:
        with suppress(OSError, TimeoutError, WebSocketException):
            await client(*arguments)
        await asyncio.sleep(1.0)


async def main(url: str, seconds: float) -> None:
    """Connect the first wave, and then all kinds of clients at once."""
    await asyncio.gather(*(attack(url, random.Random(seed)) for seed in range(WAVE)))
    print("the first wave has gone", flush=True)
    rng = random.Random(1)
    clients = [
        (read, url, TELEMETRY), (read, url, CLOUDS, CLOUD_MS), (read, url, PICTURES, PICTURE_MS), (steer, url),
        (come_and_vanish, url, rng), (besiege, url, rng), (stop_reading, url),
    ]  # fmt: skip
    with suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            await asyncio.gather(*(again(*client) for client in clients))


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], float(sys.argv[2])))
