"""RosbridgeClient: connects the simulator to a ROS graph through a rosbridge_server, as the paper's simulator did.

It asks which ROS the server is of, advertises topics and services and subscribes to command topics, and does so again
after each reconnection. While connected, every topic is read at its rate, since rosbridge does not report whether a
topic has subscribers. The simulator's thread never waits, since readings pass through bounded queues, one per topic,
that drop the oldest. If the server closes the connection because a message was too large, messages of that size or
larger are no longer sent. What the server refuses, which it reports only in the ROS graph's log, is read there and
logged; a server that refuses everything is not called connected.
"""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import Iterable
from contextlib import suppress
from functools import partial
from typing import Any, Self

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI

from uwsim.bridges.bridge import Bridge
from uwsim.bridges.doors.listener import post
from uwsim.bridges.nodes.websocket import FIRST_WAIT_S, LONGEST_WAIT_S, checked_url, why_not_connected
from uwsim.bridges.rosbridge.encoding import publication, to_json
from uwsim.bridges.rosbridge.joining import Joining, RefusedError
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parse import parse
from uwsim.channels import Channel, Service
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import Line, Turns, queue_of
from uwsim.channels.ros.messages import Ros, from_plain, spelled
from uwsim.live import LiveSimulator, NotRunningError

STOP_S = 5.0
TRIAL_S = 1.0  # at most, in which topics are sent before the server counts as connected
CLOCK = "clock"
TOO_LARGE = 1009  # RFC 6455: close code for a message that was too large


class RosbridgeClient(Bridge):
    """Connects a live simulator to a rosbridge server.

    url: the server's URL, such as "ws://host:9090". channels, services: what to publish, subscribe to and offer. ros:
    the server's ROS generation if it does not show it; by default 1. feed: shared with other sinks. Raises ValueError.
    """

    peer = "a client of the rosbridge server"

    def __init__(
        self,
        live: LiveSimulator,
        url: str,
        *,
        channels: Iterable[Channel],
        services: Iterable[Service] = (),
        ros: Ros | None = None,
        limits: Limits | None = None,
        feed: Readings | None = None,
    ) -> None:
        self.url = checked_url(url)
        super().__init__("rosbridge", live, channels, services, feed)
        self._given = ros
        self._limits = limits or Limits(frame_bytes=16 << 20)
        self._waiting: Turns[Reading] = Turns()
        self._lines: dict[str, Line[Reading]] = {
            name: Line(name, queue_of(channel.type), channel.drops) for name, channel in self.outputs.items()
        }
        self._answers: set[asyncio.Future[None]] = set()
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self.connected = threading.Event()
        self.trouble = ""  # the reason for not being connected; "" while connected
        self.is_refused = False  # whether the last server refused everything
        self.connections = 0
        self.sent = 0
        self._largest_sent = 0  # size in bytes of the largest message sent on this connection
        self._refused_bytes: int | None = None  # messages of this size or larger are no longer sent
        self._left_out: set[str] = set()
        self._joining: Joining | None = None  # of this connection

    def __repr__(self) -> str:
        return f"<RosbridgeClient of {self.url}>"

    @property
    def refusals(self) -> str:
        """Sentences about our requests and messages that the server refuses."""
        return "" if self._joining is None else self._joining.sentences

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
                self.trouble, self.is_refused = "the connection has ended", False
            except (OSError, TimeoutError, ConnectionClosed, InvalidHandshake, InvalidURI, ValueError) as error:
                self.trouble, self.is_refused = why_not_connected(error), isinstance(error, RefusedError)
                if isinstance(error, ConnectionClosed) and error.rcvd is not None and error.rcvd.code == TOO_LARGE:
                    self._refused_bytes = self._largest_sent
            if self.connections > before and not self.is_refused:
                wait_s = FIRST_WAIT_S
            self.log.warning("%s: %s; next attempt in %g s", self.url, self.trouble, wait_s)
            await asyncio.sleep(wait_s)
            wait_s = min(2.0 * wait_s, LONGEST_WAIT_S)

    async def _converse(self, connection: ClientConnection) -> None:
        topics = [f"/{name}" for name in self.outputs]
        self._joining = joining = Joining(connection, self._given, topics, self.log, self.url)
        self._largest_sent = 0
        listening = asyncio.create_task(self._listen(connection, joining))
        others = self._speak(connection, joining), joining.follow_refusals()
        tasks = [listening, *map(asyncio.create_task, others)]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in sorted(done, key=lambda task: task is not listening):  # which knows why a connection ended
                task.result()
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
            joining.log_refusals()

    async def _listen(self, connection: ClientConnection, joining: Joining) -> None:
        async for frame in connection:
            self._receive(frame, connection, joining)

    async def _speak(self, connection: ClientConnection, joining: Joining) -> None:
        """Introduce the simulator, and send readings; the server counts as connected if it takes the first ones."""
        await joining.begin()
        await joining.introduce(self._introduction(joining.ros))
        if joining.ros == 1 and CLOCK in self.outputs:  # one parameter for all nodes; in ROS 2 each node has its own
            await joining.call("/rosapi/set_param", {"name": "/use_sim_time", "value": "true"})
        self._read_channels()
        await self._write(connection, joining, topics=1)
        if await joining.is_refused():
            await self._write(connection, joining, topics=len(self.outputs))
            await joining.is_refused()
            joining.require_topics()
        self.connections += 1
        self.connected.set()
        self.trouble, self.is_refused = "", False
        self.log.info("%s: connected, to ROS %d", self.url, joining.ros)
        await self._write(connection, joining)

    def _introduction(self, ros: Ros) -> Iterable[dict[str, Any]]:
        for channel in self.outputs.values():
            kind = spelled(channel.type, ros)
            yield {"op": "advertise", "topic": f"/{channel.name}", "type": kind, "latch": channel.delivery.latched}
        for channel in self.inputs.values():
            kind = spelled(channel.type, ros)
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

    async def _write(self, connection: ClientConnection, joining: Joining, topics: int | None = None) -> None:
        """Send readings; with `topics`, only until so many were sent, for TRIAL_S at most."""
        loop, sent = asyncio.get_running_loop(), set[str]()
        end_s = math.inf if topics is None else loop.time() + TRIAL_S
        while (topics is None or len(sent) < topics) and loop.time() < end_s:
            self._wakes.clear()
            while (turn := self._waiting.take(wait=False)) is not None:
                await self._send(turn[1], connection, joining)
                if topics is not None:
                    sent.add(turn[1].channel.name)
                    if len(sent) >= topics or loop.time() > end_s:
                        return
            with suppress(TimeoutError):
                async with asyncio.timeout_at(None if topics is None else end_s):
                    await self._wakes.wait()

    async def _send(self, reading: Reading, connection: ClientConnection, joining: Joining) -> None:
        name = reading.channel.name
        if joining.refusals.refuses(f"/{name}"):  # each message would be an error in the ROS graph's log
            return
        frame = publication(reading.message, f"/{name}", joining.ros, joining.refusals.next_id(f"/{name}"))
        size = len(frame)
        if self._refused_bytes is not None and size >= self._refused_bytes:
            if name not in self._left_out:
                self._left_out.add(name)
                self.log.warning("%s: topic '%s': messages of %d bytes are too large, left out", self.url, name, size)
            return
        self._largest_sent = max(self._largest_sent, size)
        joining.refusals.count_sent(f"/{name}")
        await connection.send(frame)
        self.sent += 1

    def _receive(self, frame: str | bytes, connection: ClientConnection, joining: Joining) -> None:
        """Handle a frame from the server, logging any errors."""
        try:
            operation = parse(frame, self._limits.nesting)
            if joining.read(operation):
                return
            if operation.get("op") == "publish":
                channel = self.inputs.get(str(operation.get("topic")).lstrip("/"))
                if channel is not None:
                    self.apply(channel, from_plain(channel.type, operation.get("msg", {})))
            elif operation.get("op") == "call_service":
                self._serve(operation, connection)
        except (ValueError, NotRunningError) as error:
            self.log.warning("%s: %s", self.url, error)

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
