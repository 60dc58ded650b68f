"""Client: a client of a rosbridge server that keeps its connection, for the simulator, missions and pilots alike.

No method but `ask` waits: what is sent passes through bounded queues, one per topic, that drop the oldest.
"""

from __future__ import annotations

import asyncio
import itertools
import logging
import math
import secrets
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from logging import Logger
from typing import Any

from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from uwsim.bridges.doors.conversation import first_of
from uwsim.bridges.doors.dialler import WebSocketDialler
from uwsim.bridges.doors.listener import post
from uwsim.bridges.rosbridge.encoding import publication, to_json
from uwsim.bridges.rosbridge.joining import OPTIONAL, TEXT_SHOWN, Joining, RefusedError
from uwsim.bridges.rosbridge.parse import parse
from uwsim.channels.channel import Drops
from uwsim.channels.delivery.outgoing import QUEUE, Line, Turns
from uwsim.channels.ros.messages import Ros, from_plain, spelled

TRIAL_S = 1.0  # at most, in which topics are sent before the server counts as connected
FRAME_BYTES, NESTING = 64 << 20, 32
REQUESTS = 1000  # that may wait to be sent
TOO_LARGE = 1009  # RFC 6455: close code for a message that was too large

Operation = dict[str, Any]
Frame = Callable[[], str | None]
"""Encodes what is sent next; None if it is not to be sent."""
Respond = Callable[[bool, Any], object]


class Client(WebSocketDialler):
    """A client of a rosbridge server; all methods may be called on any thread. It is a context manager.

    What is advertised, subscribed to and offered is so again after each reconnection. Messages are received in CBOR and
    sent in JSON with literal NaN and Infinity, which all servers accept.

    queue: the most messages of a topic that wait to be sent, here and at the server. keeps: see Dialler. log: of a
    client that asks which ROS the server is of and what it refuses; others use ROS 1's spelling, which all understand.
    ros: the generation of a server that does not show it. introduced, joined, left: called when the topics have been
    announced, when the server counts as connected, and when a connection has ended. failed: called with the reason why
    an attempt or a connection has ended, and the time until the next. report: called with what the server reports. All
    functions that are passed to a client are called on its thread, which they must not block.
    """

    def __init__(
        self,
        url: str,
        *,
        queue: int = QUEUE,
        keeps: bool = True,
        log: Logger | None = None,
        ros: Ros | None = None,
        frame_bytes: int = FRAME_BYTES,
        introduced: Callable[[], object] = lambda: None,
        joined: Callable[[], object] = lambda: None,
        left: Callable[[], object] = lambda: None,
        failed: Callable[[str, float], object] = lambda why, wait_s: None,
        report: Callable[[str], object] = lambda text: None,
    ) -> None:
        super().__init__(url, keeps=keeps, frame_bytes=frame_bytes, thread="uwsim-rosbridge-client")
        self._queue, self._log, self._given, self._introduced = queue, log, ros, introduced
        self._joined, self._left, self._failed, self._report = joined, left, failed, report
        self.ros: Ros = ros or 1
        self.is_refused = False  # whether the last server refused everything
        self.joining: Joining | None = None  # of this connection, of a client that asks
        self._mark = ""
        self._lock = threading.Lock()
        self._waiting: Turns[Frame] = Turns()
        self._requests: Line[Frame] = Line("", REQUESTS)
        self._lines: dict[str, Line[Frame]] = {}
        self._wanted: dict[tuple[str, str], Callable[[], Operation]] = {}
        self._inputs: dict[str, tuple[str, Callable[[Any], object]]] = {}
        self._services: dict[str, Callable[[Operation, Respond], object]] = {}
        self._calls = itertools.count(1)
        self._answers: dict[str, Callable[[Operation], object]] = {}
        self._connection: ClientConnection | None = None
        self._has_introduced = False
        self._sent_topics, self._left_out = set[str](), set[str]()
        self._largest_sent, self._refused_bytes = 0, math.inf  # the largest message sent, the smallest not sent again

    def advertise(
        self, topic: str, kind: str, *, latch: bool = False, queue: int | None = None, drops: Drops | None = None
    ) -> None:
        """Announce messages of a type on a topic. drops: counts those that gave way to newer ones."""
        self._lines.setdefault(_slashed(topic), Line(topic, queue or self._queue, drops))
        self._want("advertise", topic, lambda: {"type": spelled(kind, self.ros), "latch": latch})

    def publish(self, topic: str, make: Callable[[], Any]) -> None:
        """Send the message that a function returns when its turn comes, if there is a connection."""
        self._put(self._lines[_slashed(topic)], lambda: self._publication(_slashed(topic), make()))

    def subscribe(
        self, topic: str, kind: str, take: Callable[[Any], object], *, options: Operation | None = None
    ) -> None:
        """Call a function with each message on a topic. options: of the request."""
        self._inputs[_slashed(topic)] = kind, take
        more = options or {"queue_length": self._queue, "compression": "cbor"}
        self._want("subscribe", topic, lambda: {"type": spelled(kind, self.ros), **more})

    def serve(self, service: str, kind: str, answer: Callable[[Operation, Respond], object]) -> None:
        """Offer a service. answer: called with the arguments, and a function that responds, from any thread."""
        self._services[_slashed(service)] = answer
        self._want("advertise_service", service, lambda: {"type": kind.replace("/srv/", "/")})

    def call(
        self,
        service: str,
        answer: Callable[[Operation], object] = lambda response: None,
        arguments: Operation | None = None,
        patience_s: float | None = None,
    ) -> None:
        """Call a service, which the server may lack.

        answer: receives the response with `result`, and `values` or the reason for a failure; {} if there is none
        after patience_s, or when the connection ends.
        """
        name = f"{self._mark}{OPTIONAL} {next(self._calls)}"
        with self._lock:
            if is_connected := self._connection is not None:
                self._answers[name] = answer
        if not is_connected:
            answer({})
            return
        request = {"op": "call_service", "service": _slashed(service), "id": name, "args": arguments or {}}
        self._put(self._requests, lambda: to_json(request))
        if patience_s is not None:
            post(self._loop, self._loop.call_later, patience_s, self._answer, name, {})

    def ask(self, service: str, arguments: Operation | None = None, patience_s: float = 10.0) -> Operation:
        """Return the answer to a call, or {}; not to be called on the client's thread."""
        found: Future[Operation] = Future()
        self.call(service, found.set_result, arguments, patience_s)
        return found.result()

    def _want(self, op: str, name: str, rest: Callable[[], Operation]) -> None:
        key = "service" if op == "advertise_service" else "topic"
        with self._lock:
            if (op, name) in self._wanted:
                return
            wanted = self._wanted[op, name] = lambda: {"op": op, key: _slashed(name), **rest()}
            is_late = self._has_introduced
        if is_late:
            self._put(self._requests, lambda: to_json(wanted()))

    def _put(self, line: Line[Frame], frame: Frame) -> None:
        with self._lock:
            if self._connection is None:
                return
            self._waiting.put(line, frame)
        if not self._wakes.is_set():
            post(self._loop, self._wakes.set)

    # On the client's thread

    async def _converse(self, connection: ClientConnection) -> None:
        self._mark, self._largest_sent = f"uwsim-{secrets.token_hex(4)}", 0
        self._sent_topics.clear()
        ways = [self._listen(connection)]  # the first knows why a connection ended
        if self._log is not None:
            self.joining = Joining(
                connection, self._given, list(self._lines), self._log, self.url, self._mark, self._report
            )
            ways.append(self.joining.follow_refusals())
        ways.append(self._speak(connection, self.joining))
        with self._lock:
            self._connection = connection
        try:
            await first_of(*ways)
        finally:
            with self._lock:
                self._connection, self._has_introduced = None, False
                answers, self._answers = list(self._answers.values()), {}
                while self._waiting.take(wait=False) is not None:
                    pass
            for answer in answers:
                answer({})
            self._left()
            if self.joining is not None:
                self.joining.log_refusals()

    async def _speak(self, connection: ClientConnection, joining: Joining | None) -> None:
        """Introduce the client, and send; a server that is asked counts as connected if it takes the first messages."""
        if joining is not None:
            await joining.begin()
            self.ros = joining.ros
        with self._lock:
            requests = [wanted() for wanted in self._wanted.values()]
            self._has_introduced = True
        for request in requests if joining is None else ():
            await connection.send(to_json(request))
        if joining is not None:
            await joining.introduce(requests)
        self._introduced()
        if joining is not None:
            await self._write(connection, 1, TRIAL_S)
            if await joining.is_refused():
                await self._write(connection, len(self._lines), TRIAL_S)
                await joining.is_refused()
                joining.require_topics()
        self.is_refused = False
        self._join()
        self._joined()
        await self._write(connection)

    async def _write(self, connection: ClientConnection, topics: float = math.inf, end_s: float | None = None) -> None:
        """Send until so many topics were sent, for end_s at most."""
        with suppress(TimeoutError):
            async with asyncio.timeout(end_s):
                while len(self._sent_topics) < topics:
                    if (turn := self._waiting.take(wait=False)) is None:
                        await self._wakes.wait()
                        self._wakes.clear()
                    elif (frame := turn[1]()) is not None:
                        await connection.send(frame)

    async def _finish(self) -> None:
        while (turn := self._waiting.take(wait=False)) is not None and self._connection is not None:
            if (frame := turn[1]()) is not None:
                await self._connection.send(frame)

    def _fail(self, error: Exception | None, wait_s: float) -> None:
        self.is_refused = isinstance(error, RefusedError)
        if isinstance(error, ConnectionClosed) and error.rcvd is not None and error.rcvd.code == TOO_LARGE:
            self._refused_bytes = self._largest_sent
        self._failed(self.trouble, wait_s)

    def _publication(self, topic: str, message: Any) -> str | None:
        joining = self.joining
        if joining is not None and topic in joining.reasons:
            return None  # each message would be an error in the ROS graph's log
        frame = publication(message, topic, self.ros, "" if joining is None else joining.next_id(topic))
        if len(frame) >= self._refused_bytes:
            if topic not in self._left_out:
                self._left_out.add(topic)
                self._report(f"topic '{topic[1:]}': messages of {len(frame)} bytes are too large, left out")
            return None
        self._largest_sent = max(self._largest_sent, len(frame))
        self._sent_topics.add(topic)
        return frame

    async def _listen(self, connection: ClientConnection) -> None:
        async for frame in connection:
            try:
                self._receive(parse(frame, NESTING), connection)
            except (ValueError, RuntimeError) as error:
                self._report(str(error))
            except Exception:  # of a function that takes messages
                logging.getLogger("uwsim.rosbridge").exception("%s: a message could not be handled", self.url)

    def _receive(self, operation: Operation, connection: ClientConnection) -> None:
        op = operation.get("op")
        if self.joining is not None and self.joining.read(operation):
            return
        if op == "publish" and (known := self._inputs.get(_slashed(str(operation.get("topic"))))) is not None:
            known[1](from_plain(known[0], operation.get("msg", {})))
        elif op == "service_response":
            self._answer(str(operation.get("id")), operation)
        elif op == "call_service" and (service := self._services.get(str(operation.get("service")))) is not None:
            arguments = operation.get("args")
            arguments = arguments if isinstance(arguments, dict) else {}
            service(arguments, partial(self._respond, operation, connection))
        elif op == "status":
            self._report(str(operation.get("msg"))[:TEXT_SHOWN])

    def _answer(self, name: str, response: Operation) -> None:
        with self._lock:
            answer = self._answers.pop(name, None)
        if answer is not None:
            answer(response)

    def _respond(self, asked: Operation, connection: ClientConnection, succeeded: bool, values: Any) -> None:
        head = {"op": "service_response", "id": asked.get("id"), "service": asked.get("service")}
        try:
            frame = to_json(head | {"values": values, "result": succeeded})
        except ValueError as error:
            frame = to_json(head | {"values": str(error), "result": False})
        if connection is self._connection:  # otherwise the caller is gone
            self._put(self._requests, lambda: frame)


def _slashed(name: str) -> str:
    return f"/{name.lstrip('/')}"
