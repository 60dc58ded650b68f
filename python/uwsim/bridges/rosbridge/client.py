"""RosbridgeClient: connects the simulator to a ROS graph through a rosbridge_server, as the paper's simulator did.

It advertises topics and services and subscribes to command topics, and does so again after each reconnection. While
connected, every topic is read at its rate, since rosbridge does not report whether a topic has subscribers. The
simulator's thread never waits, since readings pass through bounded queues, one per topic, that drop the oldest. If the
server closes the connection because a message was too large, messages of that size or larger are no longer sent.
What the server refuses, which it reports only in the ROS graph's log, is read there and logged.
"""

from __future__ import annotations

import asyncio
import secrets
import threading
from collections.abc import Iterable
from functools import partial
from typing import Any, Self

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI

from uwsim.bridges.bridge import Bridge
from uwsim.bridges.listener import post
from uwsim.bridges.nodes.websocket import FIRST_WAIT_S, LONGEST_WAIT_S, checked_url, why_not_connected
from uwsim.bridges.rare_log import RareLog
from uwsim.bridges.rosbridge.encoding import publication, to_json
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parse import parse
from uwsim.bridges.rosbridge.refusals import ROSOUT, Refusals
from uwsim.channels import Channel, Service
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import Line, Turns, queue_of
from uwsim.channels.ros.messages import Ros, from_plain, spelled
from uwsim.live import LiveSimulator, NotRunningError

STOP_S = 5.0
LOG_WAIT_S = 2.0  # for the first line of the ROS graph's log
REFUSALS_S = 1.0  # without a further refusal, after which those collected are logged
TOO_LARGE = 1009  # RFC 6455: close code for a message that was too large


class RosbridgeClient(Bridge):
    """Connects a live simulator to a rosbridge server.

    url: the server's URL, such as "ws://host:9090". channels, services: what to publish, subscribe to and offer. ros:
    the ROS generation whose spelling of types, times and headers the server expects. feed: shared with other sinks.
    Raises ValueError.
    """

    peer = "a client of the rosbridge server"

    def __init__(
        self,
        live: LiveSimulator,
        url: str,
        *,
        channels: Iterable[Channel],
        services: Iterable[Service] = (),
        ros: Ros = 1,
        limits: Limits | None = None,
        feed: Readings | None = None,
    ) -> None:
        self.url = checked_url(url)
        super().__init__("rosbridge", live, channels, services, feed)
        self._ros: Ros = ros
        self._limits = limits or Limits(frame_bytes=16 << 20)
        self._waiting: Turns[Reading] = Turns()
        self._lines: dict[str, Line[Reading]] = {
            name: Line(name, queue_of(channel.type), channel.drops) for name, channel in self.outputs.items()
        }
        self._rare = RareLog(self.log)
        self._answers: set[asyncio.Future[None]] = set()
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self.connected = threading.Event()
        self.trouble = ""  # the reason for not being connected; "" while connected
        self.refusals = ""  # what the server refuses of ours, in sentences
        self.connections = 0
        self.sent = 0
        self._largest_sent = 0  # size in bytes of the largest message sent on this connection
        self._refused_bytes: int | None = None  # messages of this size or larger are no longer sent
        self._left_out: set[str] = set()
        self._refusals = Refusals(ros, "")
        self._reads_log = asyncio.Event()

    def __repr__(self) -> str:
        return f"<RosbridgeClient of {self.url}>"

    def start(self) -> Self:
        """Start connecting; return self."""
        if self._thread is not None:
            raise RuntimeError("the client is already running")
        ready = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._run(ready)), name="uwsim-rosbridge-client", daemon=True
        )
        self._thread.start()
        ready.wait()
        return self

    def __enter__(self) -> Self:
        return self.start()

    def close(self) -> bool:
        """Disconnect and stop the thread."""
        was_open = super().close()
        if was_open and self._thread is not None and self._loop is not None:
            post(self._loop, self._stopping.set)
            self._thread.join(STOP_S)
        return was_open

    stop = close

    async def _run(self, ready: threading.Event) -> None:
        self._loop = asyncio.get_running_loop()
        self._stopping, self._wakes = asyncio.Event(), asyncio.Event()
        ready.set()
        keeping = asyncio.create_task(self._keep_connected())
        await self._stopping.wait()
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    async def _keep_connected(self) -> None:
        """Connect repeatedly, pausing longer after each failure; one that ends before the introduction is another."""
        wait_s = FIRST_WAIT_S
        while True:
            before = self.connections
            try:
                async with connect(
                    self.url, compression=None, max_size=self._limits.frame_bytes, close_timeout=1, open_timeout=5
                ) as connection:
                    await self._converse(connection)
                self.trouble = "the connection has ended"
            except (OSError, TimeoutError, ConnectionClosed, InvalidHandshake, InvalidURI, ValueError) as error:
                self.trouble = why_not_connected(error)
                if isinstance(error, ConnectionClosed) and error.rcvd is not None and error.rcvd.code == TOO_LARGE:
                    self._refused_bytes = self._largest_sent
            if self.connections > before:
                wait_s = FIRST_WAIT_S
            self.log.warning("%s: %s; next attempt in %g s", self.url, self.trouble, wait_s)
            await asyncio.sleep(wait_s)
            wait_s = min(2.0 * wait_s, LONGEST_WAIT_S)

    async def _converse(self, connection: ClientConnection) -> None:
        self._refusals = Refusals(self._ros, f"uwsim-{secrets.token_hex(4)}")
        self._reads_log = asyncio.Event()
        self._largest_sent, self.refusals = 0, ""
        tasks = [asyncio.create_task(self._speak(connection)), asyncio.create_task(self._report_refusals())]
        try:
            async for frame in connection:
                self._receive(frame, connection)
        finally:
            self.connected.clear()
            for task in tasks:
                task.cancel()
            for name in self.outputs:
                self.leave(name)
            for channel in self.inputs.values():
                self.abandon(channel)
            while self._waiting.take(wait=False) is not None:
                pass
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _speak(self, connection: ClientConnection) -> None:
        """Subscribe to the ROS graph's log, introduce the simulator, then send readings."""
        for operation in self._refusals.greeting():
            await connection.send(to_json(operation))
        try:
            async with asyncio.timeout(LOG_WAIT_S):
                await self._reads_log.wait()
        except TimeoutError:
            self.log.warning("%s: /%s cannot be read: refusals by the server remain unknown", self.url, ROSOUT)
        for operation in self._refusals.marked(self._introduction()):
            await connection.send(to_json(operation))
        self._read_channels()
        self.connections += 1
        self.connected.set()
        self.trouble = ""
        self.log.info("%s: connected", self.url)
        await self._write(connection)

    async def _report_refusals(self) -> None:
        """Log refusals when no further one has followed for REFUSALS_S, and at the end of the connection."""
        reported = seen = self._refusals.names
        try:
            while True:
                await asyncio.sleep(REFUSALS_S)
                if reported != seen == self._refusals.names:
                    reported = seen
                    self._log_refusals()
                seen = self._refusals.names
        finally:
            if reported != self._refusals.names:
                self._log_refusals()

    def _log_refusals(self) -> None:
        sentences = self._refusals.summary()
        self.refusals = "; ".join(sentences)
        for sentence in sentences:
            self.log.warning("%s: %s", self.url, sentence)

    def _introduction(self) -> Iterable[dict[str, Any]]:
        for channel in self.outputs.values():
            kind = spelled(channel.type, self._ros)
            yield {"op": "advertise", "topic": f"/{channel.name}", "type": kind, "latch": channel.delivery.latched}
        for channel in self.inputs.values():
            kind = spelled(channel.type, self._ros)
            yield {"op": "subscribe", "topic": f"/{channel.name}", "type": kind, "queue_length": 1}
        for service in self.services.values():
            yield {"op": "advertise_service", "service": f"/{service.name}", "type": service.type.replace("/srv/", "/")}

    def _read_channels(self) -> None:
        try:
            for name in self.outputs:
                self.listen(name)
        except NotRunningError:
            self.log.warning("the simulator does not run")

    def take(self, reading: Reading) -> None:
        """Queue a reading on the simulator's thread."""
        self._waiting.put(self._lines[reading.channel.name], reading)
        if self._loop is not None and not self._wakes.is_set():
            post(self._loop, self._wakes.set)

    async def _write(self, connection: ClientConnection) -> None:
        while True:
            self._wakes.clear()
            while (turn := self._waiting.take(wait=False)) is not None:
                await self._send(turn[1], connection)
            await self._wakes.wait()

    async def _send(self, reading: Reading, connection: ClientConnection) -> None:
        name = reading.channel.name
        if f"/{name}" in self._refusals.names:  # each message would be an error in the ROS graph's log
            return
        frame = publication(reading.message, f"/{name}", self._ros)
        size = len(frame)
        if self._refused_bytes is not None and size >= self._refused_bytes:
            if name not in self._left_out:
                self._left_out.add(name)
                self.log.warning("%s: topic '%s': messages of %d bytes are too large, left out", self.url, name, size)
            return
        self._largest_sent = max(self._largest_sent, size)
        await connection.send(frame)
        self.sent += 1

    def _receive(self, frame: str | bytes, connection: ClientConnection) -> None:
        """Handle a frame from the server, logging any errors."""
        try:
            operation = parse(frame, self._limits.nesting)
            if operation.get("op") == "publish":
                name = str(operation.get("topic")).lstrip("/")
                channel = self.inputs.get(name)
                if name == ROSOUT:
                    self._read_log(operation.get("msg"))
                elif channel is not None:
                    self.apply(channel, from_plain(channel.type, operation.get("msg", {})))
            elif operation.get("op") == "call_service":
                self._serve(operation, connection)
            elif operation.get("op") == "status":
                self._rare.warning(f"{self.url} reports: {str(operation.get('msg'))[:500]}")
        except (ValueError, NotRunningError) as error:
            self.log.warning("%s: %s", self.url, error)

    def _read_log(self, message: Any) -> None:
        if not isinstance(message, dict):
            return
        if self._refusals.is_greeting(message):
            self._reads_log.set()
        elif (text := self._refusals.read(message)) is not None:
            self._rare.warning(f"{self.url} reports: {text}")

    def _serve(self, operation: dict[str, Any], connection: ClientConnection) -> None:
        service, arguments = self.services.get(str(operation.get("service")).lstrip("/")), operation.get("args")
        if service is None:
            return
        head = {"op": "service_response", "id": operation.get("id"), "service": f"/{service.name}"}
        respond = partial(post, asyncio.get_running_loop(), self._respond, head, connection)
        self.call(service, arguments if isinstance(arguments, dict) else {}, respond)

    def _respond(self, head: dict[str, Any], connection: ClientConnection, succeeded: bool, values: Any) -> None:
        try:
            frame = to_json(head | {"values": values, "result": succeeded})
        except ValueError as error:
            frame = to_json(head | {"values": str(error), "result": False})
        sending = asyncio.ensure_future(connection.send(frame))
        self._answers.add(sending)
        sending.add_done_callback(self._forget_answer)

    def _forget_answer(self, sending: asyncio.Future[None]) -> None:
        self._answers.discard(sending)
        if not sending.cancelled():
            sending.exception()  # read so that it is not logged: the caller is gone with the connection
