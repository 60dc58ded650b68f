"""RosbridgeClient: the simulator joins a real ROS graph through somebody's rosbridge_server, as the paper's did.

It advertises what it says and the services that it offers, subscribes to what it hears, and does so again whenever the
connection comes back. Every topic is read at its rate as long as the connection stands: rosbridge does not tell who
listens. The simulator's thread never waits: readings pass through a bounded queue, whose oldest give way. Where the
server closes the connection since a message was too large for it, messages of that size are left out from then on.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Iterable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from types import TracebackType
from typing import Any, Self

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI

from uwsim.bridges.rosbridge.encoding import Sample, to_json
from uwsim.bridges.rosbridge.graph import LOGGER
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parse import parse
from uwsim.channels import Channel, Service
from uwsim.channels.messages import Ros, from_plain, spelled
from uwsim.live import LiveSimulator, NotRunningError, Subscription

FIRST_WAIT_S = 0.25
LONGEST_WAIT_S = 10.0
WAITING = 200
STOP_S = 5.0
TOO_LARGE = 1009  # RFC 6455: the code of a connection that was closed by a message of that kind


class RosbridgeClient:
    """A live simulator at a rosbridge server.

    url: such as "ws://host:9090". channels, services: what it says, hears and offers. ros: whose spelling of types,
    times and headers the server expects. Raises ValueError.
    """

    def __init__(
        self,
        live: LiveSimulator,
        url: str,
        *,
        channels: Iterable[Channel],
        services: Iterable[Service] = (),
        ros: Ros = 1,
        limits: Limits | None = None,
    ) -> None:
        if not url.startswith(("ws://", "wss://")):
            raise ValueError(f"url = '{url}': must begin with ws:// or wss://")
        self.url = url
        self._live = live
        self._ros: Ros = ros
        self._limits = limits or Limits(frame_bytes=16 << 20)
        channels = list(channels)
        self._said = [channel for channel in channels if channel.direction == "out"]
        self._heard = {channel.name: channel for channel in channels if channel.direction == "in"}
        self._services = {service.name: service for service in services}
        self._waiting: deque[tuple[str, Any]] = deque(maxlen=WAITING)
        self._answers: set[asyncio.Future[None]] = set()
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self.connected = threading.Event()
        self.connections = 0
        self.sent = 0
        self._largest_sent = 0  # bytes, in this connection
        self._refused_bytes: int | None = None  # the size from which on messages are left out
        self._left_out: set[str] = set()

    def start(self) -> Self:
        """Begin to connect; return itself."""
        if self._thread is not None:
            raise RuntimeError("the client runs already")
        ready = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._run(ready)), name="uwsim-rosbridge-client", daemon=True
        )
        self._thread.start()
        ready.wait()
        return self

    def stop(self) -> None:
        """Disconnect and end."""
        if self._thread is None or self._loop is None:
            return
        self._loop.call_soon_threadsafe(self._stopping.set)
        self._thread.join(STOP_S)
        self._thread = None

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self.stop()

    async def _run(self, ready: threading.Event) -> None:
        self._loop = asyncio.get_running_loop()
        self._stopping, self._wakes = asyncio.Event(), asyncio.Event()
        ready.set()
        keeping = asyncio.create_task(self._keep_connected())
        await self._stopping.wait()
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    async def _keep_connected(self) -> None:
        """Connect, again and again, ever more patiently while it fails."""
        wait_s = FIRST_WAIT_S
        while True:
            try:
                async with connect(
                    self.url, compression=None, max_size=self._limits.frame_bytes, close_timeout=1, open_timeout=5
                ) as connection:
                    wait_s = FIRST_WAIT_S
                    await self._converse(connection)
                LOGGER.warning("%s: the connection has ended", self.url)
            except (OSError, TimeoutError, ConnectionClosed, InvalidHandshake, InvalidURI) as error:
                LOGGER.warning("%s: %s; next attempt in %g s", self.url, error or type(error).__name__, wait_s)
                if isinstance(error, ConnectionClosed) and error.rcvd is not None and error.rcvd.code == TOO_LARGE:
                    self._refused_bytes = self._largest_sent
            await asyncio.sleep(wait_s)
            wait_s = min(2.0 * wait_s, LONGEST_WAIT_S)

    async def _converse(self, connection: ClientConnection) -> None:
        for operation in self._introduction():
            await connection.send(to_json(operation))
        readings = self._read_channels()
        self.connections += 1
        self._largest_sent = 0
        self.connected.set()
        LOGGER.info("%s: connected", self.url)
        writer = asyncio.create_task(self._write(connection))
        try:
            async for frame in connection:
                self._receive(frame, connection)
        finally:
            self.connected.clear()
            writer.cancel()
            for reading in readings:
                reading.cancel()
            self._waiting.clear()
            await asyncio.gather(writer, return_exceptions=True)

    def _introduction(self) -> Iterable[dict[str, Any]]:
        for channel in self._said:
            kind = spelled(channel.type, self._ros)
            yield {"op": "advertise", "topic": f"/{channel.name}", "type": kind, "latch": channel.latched}
        for channel in self._heard.values():
            kind = spelled(channel.type, self._ros)
            yield {"op": "subscribe", "topic": f"/{channel.name}", "type": kind, "queue_length": 1}
        for service in self._services.values():
            yield {"op": "advertise_service", "service": f"/{service.name}", "type": service.type}

    def _read_channels(self) -> list[Subscription]:
        readings = []
        try:
            for channel in self._said:
                if channel.rate_hz is None:
                    self._live.read(channel.read).add_done_callback(partial(self._arrive_once, channel.name))
                else:
                    sink = partial(self._arrive, channel.name)
                    readings.append(self._live.every(1.0 / channel.rate_hz, channel.read, sink))
        except NotRunningError:
            LOGGER.warning("the simulator does not run")
        return readings

    def _arrive_once(self, name: str, done: Future[Any]) -> None:
        if done.exception() is None:
            self._arrive(name, done.result())
        else:
            LOGGER.error("topic '%s': %s", name, done.exception())

    def _arrive(self, name: str, message: Any) -> None:
        """Queue a reading, on the simulator's thread."""
        if message is None or self._loop is None:
            return
        was_empty = not self._waiting
        self._waiting.append((name, message))
        if was_empty and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._wakes.set)

    async def _write(self, connection: ClientConnection) -> None:
        while True:
            while self._waiting:
                name, message = self._waiting.popleft()
                await self._send(name, message, connection)
            self._wakes.clear()
            if not self._waiting:
                await self._wakes.wait()

    async def _send(self, name: str, message: Any, connection: ClientConnection) -> None:
        frame = Sample(message).frame(f"/{name}", self._ros, "none")
        size = len(frame)
        if self._refused_bytes is not None and size >= self._refused_bytes:
            if name not in self._left_out:
                self._left_out.add(name)
                LOGGER.warning("%s: topic '%s': messages of %d bytes are too large, left out", self.url, name, size)
            return
        self._largest_sent = max(self._largest_sent, size)
        await connection.send(frame)
        self.sent += 1

    def _receive(self, frame: str | bytes, connection: ClientConnection) -> None:
        """Apply what the server sends. What is wrong is logged."""
        try:
            operation = parse(frame, self._limits.nesting)
            if operation.get("op") == "publish":
                channel = self._heard.get(str(operation.get("topic")).lstrip("/"))
                if channel is not None:
                    channel.apply(self._live, from_plain(channel.type, operation.get("msg", {})))
            elif operation.get("op") == "call_service":
                self._serve(operation, connection)
            elif operation.get("op") == "status":
                LOGGER.warning("%s says: %s", self.url, str(operation.get("msg"))[:500])
        except (ValueError, NotRunningError) as error:
            LOGGER.warning("%s: %s", self.url, error)

    def _serve(self, operation: dict[str, Any], connection: ClientConnection) -> None:
        service = self._services.get(str(operation.get("service")).lstrip("/"))
        if service is not None:
            task = asyncio.ensure_future(self._answer(service, operation, connection))
            self._answers.add(task)
            task.add_done_callback(self._answers.discard)

    async def _answer(self, service: Service, operation: dict[str, Any], connection: ClientConnection) -> None:
        """Answer a call, served on another thread: it may wait for steps."""
        arguments = operation.get("args")
        answer: dict[str, Any] = {"op": "service_response", "id": operation.get("id"), "service": f"/{service.name}"}
        try:
            values = await asyncio.to_thread(service.call, self._live, arguments if isinstance(arguments, dict) else {})
            frame = to_json(answer | {"values": values, "result": True})
        except (ValueError, RuntimeError) as error:
            frame = to_json(answer | {"values": str(error), "result": False})
        with suppress(ConnectionClosed):
            await connection.send(frame)
