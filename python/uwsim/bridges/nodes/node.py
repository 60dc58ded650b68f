"""Node: a connection to a rosbridge server that subscribes, publishes and runs callbacks one at a time."""

from __future__ import annotations

import itertools
import secrets
import time
from collections.abc import Callable
from typing import Any

from websockets.exceptions import ConnectionClosed

from uwsim.bridges.nodes.websocket import WebSocket
from uwsim.bridges.rosbridge.encoding import publication, to_json
from uwsim.bridges.rosbridge.parse import parse
from uwsim.bridges.rosbridge.refusals import Refusals
from uwsim.channels.ros.messages import Ros, from_plain, spelled

ROS: Ros = 1  # whose spelling every rosbridge understands
NESTING = 32


class Node:
    """A client of a rosbridge server. It uses ROS 1's spelling of types and messages.

    Messages are received in CBOR and sent in JSON with literal NaN and Infinity, which all servers accept. queue: the
    maximum number of waiting messages per topic, beyond which the oldest are dropped. complain: called with errors that
    the server reports. Functions returned by `advertise`, and `call`, may be used on any thread. Raises OSError if the
    server cannot be reached.
    """

    def __init__(self, url: str, queue: int) -> None:
        self._refusals = Refusals(ROS, f"uwsim-{secrets.token_hex(4)}")
        self._connection = WebSocket(url)
        self.complain: Callable[[str], object] = lambda text: None
        self._queue = queue
        self._calls = itertools.count(1)
        self._answers: dict[str, Callable[[dict[str, Any]], object]] = {}
        self._callbacks: dict[str, tuple[str, Callable[[Any], None]]] = {}

    def advertise(self, topic: str, kind: str) -> Callable[[Any], None]:
        """Return a function that publishes messages of a given type on a topic."""
        self._send({"op": "advertise", "topic": topic, "type": spelled(kind, ROS), "queue_size": self._queue})
        return lambda message: self._publish(topic, message)

    def _publish(self, topic: str, message: Any) -> None:
        name = f"/{topic.lstrip('/')}"
        if not self._refusals.refuses(name):
            identity = self._refusals.next_id(name)
            self._refusals.count_sent(name)
            self._connection.send(publication(message, topic, ROS, identity))

    def subscribe(self, topic: str, kind: str, callback: Callable[[Any], None]) -> None:
        """Call a function with each message on a topic."""
        self._callbacks[topic] = kind, callback
        self._send(
            {
                "op": "subscribe", "topic": topic, "type": spelled(kind, ROS),
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
            if op == "publish" and (topic := str(operation.get("topic"))) in self._callbacks:
                kind, callback = self._callbacks[topic]
                callback(from_plain(kind, operation.get("msg", {})))
            elif op == "service_response":
                answer = self._answers.pop(str(operation.get("id")), None)
                if answer is not None:
                    answer(operation)
            elif op == "status" and (text := self._refusals.read_status(operation)) is not None:
                self.complain(text)

    def close(self) -> None:
        """Disconnect."""
        self._connection.close()

    def _send(self, operation: dict[str, Any]) -> None:
        self._connection.send(to_json(operation))
