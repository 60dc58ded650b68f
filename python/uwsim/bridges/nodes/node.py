"""Node: a connection to a rosbridge server that subscribes, publishes and runs callbacks one at a time."""

from __future__ import annotations

import itertools
import secrets
import time
from collections.abc import Callable
from typing import Any

from websockets.exceptions import ConnectionClosed, WebSocketException

from uwsim.bridges.nodes.websocket import WebSocket, why_not_connected
from uwsim.bridges.rosbridge.encoding import publication, to_json
from uwsim.bridges.rosbridge.generation import TURN_S, Generation, chosen
from uwsim.bridges.rosbridge.parse import parse
from uwsim.bridges.rosbridge.refusals import OPTIONAL, ROSOUT, Refusals
from uwsim.channels.ros.messages import Ros, from_plain, spelled

QUEUE = 1000  # the chain has few messages, none of which should be lost
NESTING = 32


class Node:
    """A client of a rosbridge server. It uses ROS 1 spelling of types, which every rosbridge understands.

    Messages are received in CBOR and sent in JSON with literal NaN and Infinity, which all servers accept. queue: the
    maximum number of waiting messages per topic, beyond which the oldest are dropped. ros: the server's ROS generation,
    in which messages are sent; `settle` learns it from the server, and uses the given one if it does not show it.
    finish: called at the end. complain: called with errors that the server reports. refusals: the messages that it
    refuses, once `follow_refusals` was called. Functions returned by `advertise`, and `call`, may be used on any
    thread. Raises OSError if the server cannot be reached.
    """

    def __init__(self, url: str, queue: int = QUEUE, ros: Ros | None = None) -> None:
        self.url, self._given = url, ros
        self.ros: Ros = ros or 1
        self._mark = f"uwsim-{secrets.token_hex(4)}"
        self._generation = Generation(f"{self._mark}{OPTIONAL}")
        self.refusals = Refusals(self.ros, self._mark)
        self._has_answer = False  # to the last question of `settle`
        self._held: list[tuple[str, Any]] | None = None  # what is published meanwhile
        self._connection = WebSocket(url)
        self.finish: Callable[[], None] = lambda: None
        self.complain: Callable[[str], object] = lambda text: None
        self._queue = queue
        self._calls = itertools.count(1)
        self._answers: dict[str, Callable[[dict[str, Any]], object]] = {}
        self._callbacks: dict[str, tuple[str, Callable[[Any], None]]] = {}
        self._introduction: list[dict[str, Any]] = []
        self._advertised: dict[str, str] = {}

    def reconnect(self) -> None:
        """Connect again, advertise and subscribe as before; calls without an answer are forgotten.

        Raises OSError or WebSocketException.
        """
        self._connection.close()
        self._answers.clear()
        self._connection = WebSocket(self.url)
        for operation in self._introduction:
            self._send(operation)

    def advertise(self, topic: str, kind: str) -> Callable[[Any], None]:
        """Return a function that publishes messages of a given type on a topic."""
        self._advertised[f"/{topic.lstrip('/')}"] = spelled(kind, 1)
        self._introduce({"op": "advertise", "topic": topic, "type": spelled(kind, 1), "queue_size": self._queue})
        return lambda message: self._publish(topic, message)

    def _publish(self, topic: str, message: Any) -> None:
        name = f"/{topic.lstrip('/')}"
        if self._held is not None:
            self._held.append((topic, message))
        elif not self.refusals.refuses(name):
            identity = self.refusals.next_id(name)
            self.refusals.count_sent(name)
            self._connection.send(publication(message, topic, self.ros, identity))

    def subscribe(self, topic: str, kind: str, callback: Callable[[Any], None]) -> None:
        """Call a function with each message on a topic."""
        self._callbacks[topic] = kind, callback
        self._introduce(
            {
                "op": "subscribe", "topic": topic, "type": spelled(kind, 1),
                "compression": "cbor", "queue_length": self._queue,
            }
        )  # fmt: skip

    def call(
        self, service: str, answer: Callable[[dict[str, Any]], object], arguments: dict[str, Any] | None = None
    ) -> None:
        """Call a service. `answer` receives the response: `result`, and `values` or the reason for a failure."""
        name = f"call:{next(self._calls)}"
        self._answers[name] = answer
        self._send({"op": "call_service", "service": service, "id": name, "args": arguments or {}})

    def settle(self, patience_s: float = 10.0) -> str:
        """Wait until the server has processed all requests so far, which it answers in order.

        Learn which ROS it is of, and return a remark on it, if any. What callbacks publish meanwhile is sent then.
        Without rosapi this takes longer.
        """
        self._held, is_lost, end_s = [], False, time.monotonic() + patience_s
        for question in self._generation.questions():
            try:
                is_lost = not self._answers_in_time(question, min(time.monotonic() + TURN_S, end_s))
            except ConnectionClosed:
                is_lost = True
            if is_lost or self._generation.ros is not None:
                break
        self.ros, remark = chosen(self._generation.ros, self._given)
        self.refusals = Refusals(self.ros, self._mark)
        held, self._held = self._held, None
        if is_lost:  # as the next use of the connection finds
            return ""
        for operation in self._generation.ends():
            self._send(operation)
        for topic, message in held:
            self._publish(topic, message)
        return remark

    def _answers_in_time(self, question: list[dict[str, Any]], end_s: float) -> bool:
        """Ask, and wait for an answer; return whether the connection is still there."""
        self._has_answer = False
        for operation in question:
            self._send(operation)
        self.spin(lambda: self._has_answer or time.monotonic() > end_s)
        return self._has_answer or time.monotonic() > end_s

    def follow_refusals(self) -> None:
        """Subscribe to the log of the ROS graph, in which alone a rosbridge_server reports a refused message."""
        self._introduce(self.refusals.greeting()[0])

    @property
    def is_refused(self) -> bool:
        """True if every message so far was refused."""
        return self.refusals.refuses_all(self._advertised)

    def refused(self, patience_s: float = 5.0) -> dict[str, str]:
        """Return the advertised topics, with types, that the server's graph lacks after patience_s. Requires rosapi.

        A rosbridge_server that lacks the package of a topic's type reports this in its own log only.
        """
        deadline_s = time.monotonic() + patience_s
        while True:
            values = self.ask("/rosapi/topics").get("values")
            if not isinstance(values, dict) or not isinstance(known := values.get("topics"), list):
                return {}
            missing = {name: kind for name, kind in self._advertised.items() if name not in known}
            if not missing or time.monotonic() >= deadline_s:
                return missing
            time.sleep(0.1)

    def ask(self, service: str, patience_s: float = 10.0) -> dict[str, Any]:
        """Return the answer to a call, or {} if there is none after patience_s."""
        answers: list[dict[str, Any]] = []
        self.call(service, answers.append)
        deadline_s = time.monotonic() + patience_s
        self.spin(lambda: bool(answers) or time.monotonic() > deadline_s)
        return answers[0] if answers else {}

    def spin(self, until: Callable[[], bool] = lambda: False, wait_s: float = 0.2) -> None:
        """Run callbacks until a condition is met or the server closes the connection.

        until: the condition, which is checked between messages. Raises ConnectionClosed if a callback publishes on a
        closed connection, and the callbacks' errors.
        """
        while not until():
            try:
                frame = self._connection.recv(wait_s)
            except TimeoutError:
                continue
            except ConnectionClosed:
                return
            operation = parse(frame, NESTING)
            op = operation.get("op")
            if self._generation.read(operation):
                self._has_answer = True
            elif op == "publish" and str(operation.get("topic")).lstrip("/") == ROSOUT:
                self._read_log(operation.get("msg"))
            elif op == "publish" and (topic := str(operation.get("topic"))) in self._callbacks:
                kind, callback = self._callbacks[topic]
                callback(from_plain(kind, operation.get("msg", {})))
            elif op == "service_response":
                answer = self._answers.pop(str(operation.get("id")), None)
                if answer is not None:
                    answer(operation)
            elif op == "status" and (text := self.refusals.read_status(operation)) is not None:
                self.complain(text)

    def _read_log(self, message: Any) -> None:
        if isinstance(message, dict) and (text := self.refusals.read(message)) is not None:
            self.complain(text)

    def close(self) -> None:
        """Disconnect."""
        self._connection.close()

    def abort(self) -> None:
        """End the connection without waiting; see WebSocket.abort."""
        self._connection.abort()

    def _introduce(self, operation: dict[str, Any]) -> None:
        self._introduction.append(operation)
        self._send(operation)

    def _send(self, operation: dict[str, Any]) -> None:
        self._connection.send(to_json(operation))


def connect_patiently(url: str, patience_s: float, ros: Ros | None = None) -> Node:
    """Wait for a server and return a node. Raises OSError if there is no server after `patience_s`."""
    deadline_s = time.monotonic() + patience_s
    while True:
        try:
            return Node(url, ros=ros)
        except (OSError, WebSocketException) as error:
            if time.monotonic() > deadline_s:
                raise OSError(f"{url}: no rosbridge answers: {why_not_connected(error)}") from None
            time.sleep(0.2)
