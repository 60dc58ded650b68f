"""Typical clients of a rosbridge: some read and steer, others come and go, send garbage, or stop reading.

.venv/bin/python tools/soak/clients.py URL SECONDS
"""

from __future__ import annotations

import asyncio
import json
import random
import sys
import time
from contextlib import suppress
from typing import Any

from rosbridge import attack  # in this folder
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

PICTURES = ("/camera/front/image_raw/compressed", "/images/compressed", "/forward_looking/picture/compressed")
CLOUDS = ("/points", "/laserPointCloud", "/octomap_binary", "/scan")
TELEMETRY = ("/telemetry", "/odom", "/imu", "/tf", "/battery_state", "/diagnostics")
PICTURE_MS, CLOUD_MS = 2000, 500  # minimum interval between two messages


async def connected(url: str) -> ClientConnection:
    """Return a connection that accepts large messages."""
    return await connect(url, compression=None, max_size=None, open_timeout=60, close_timeout=1)


async def subscribe(connection: ClientConnection, topics: tuple[str, ...], every_ms: int = 0) -> None:
    """Subscribe to topics."""
    for topic in topics:
        await say(connection, op="subscribe", topic=topic, throttle_rate=every_ms, queue_length=1, compression="cbor")


async def say(connection: ClientConnection, **operation: Any) -> None:
    """Send an operation."""
    await connection.send(json.dumps(operation))


async def read(url: str, topics: tuple[str, ...], every_ms: int = 0) -> int:
    """Subscribe, and read until the connection ends."""
    count = 0
    connection = await connected(url)
    await subscribe(connection, topics, every_ms)
    async for _ in connection:
        count += 1
    return count


async def steer(url: str) -> None:
    """Undock the vehicle, and turn it on the spot, to and fro, for two seconds out of every twenty.

    The turns are short because the velocity control loop sends 20 commands per second, which stay in the simulator's
    log.
    """
    connection = await connected(url)
    await say(connection, op="subscribe", topic="/odom", throttle_rate=1000)
    turn = 0.2
    while True:
        await say(connection, op="call_service", service="/undock", args={})
        await say(connection, op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.1}, "angular": {"z": turn}})
        await listen(connection, 2.0)
        await say(connection, op="publish", topic="/cmd_wrench", msg={"torque": {"z": turn}})
        await listen(connection, 18.0)
        turn = -turn


async def listen(connection: ClientConnection, seconds: float) -> None:
    """Read messages for a given time."""
    with suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            while True:
                await connection.recv()


async def come_and_vanish(url: str, rng: random.Random) -> None:
    """Subscribe to random topics, and leave without closing the connection."""
    while True:
        connection = await connected(url)
        await subscribe(connection, (rng.choice(PICTURES), rng.choice(CLOUDS), rng.choice(TELEMETRY)), 200)
        await asyncio.sleep(rng.uniform(0.0, 4.0))
        connection.transport.abort()
        await asyncio.sleep(rng.uniform(0.0, 2.0))


async def talk_nonsense(url: str, rng: random.Random) -> None:
    """Send damaged operations and garbage."""
    while True:
        await attack(url, rng)
        await asyncio.sleep(1.0)


async def stop_reading(url: str) -> None:
    """Subscribe to all large topics and read nothing for a minute; then reconnect."""
    while True:
        connection = await connect(url, compression=None, max_queue=1, open_timeout=60, ping_interval=None)
        await subscribe(connection, CLOUDS + PICTURES[:1], 1000)
        await asyncio.sleep(60.0)
        connection.transport.abort()


async def serve_again(client: Any, *arguments: Any) -> None:
    """Run a client, and restart it whenever the server has closed its connection."""
    while True:
        with suppress(OSError, TimeoutError, WebSocketException):
            await client(*arguments)
        await asyncio.sleep(1.0)


async def main(url: str, seconds: float) -> None:
    """Run all clients at once."""
    rng = random.Random(1)
    clients = [
        serve_again(read, url, TELEMETRY),
        serve_again(read, url, CLOUDS, CLOUD_MS),
        serve_again(read, url, PICTURES, PICTURE_MS),
        serve_again(steer, url),
        serve_again(come_and_vanish, url, rng),
        serve_again(talk_nonsense, url, rng),
        serve_again(stop_reading, url),
    ]
    with suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            await asyncio.gather(*clients)


if __name__ == "__main__":
    began_s = time.monotonic()
    asyncio.run(main(sys.argv[1], float(sys.argv[2])))
