"""RemoteConnection: access to services and to the latest message on each topic, over rosbridge."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Any, Self

from uwsim.bridges.rare_log import RareLog
from uwsim.bridges.rosbridge.client import Client
from uwsim.channels.ros.message_types import resolve

ANSWER_S = 20.0  # time limit for a response or a first message
KEPT = 200  # number of messages kept for topics whose time stamps matter
LOST = "the connection to the vehicle is lost"


class RemoteConnection:
    """A connection to a rosbridge server, which is not renewed. It is a context manager.

    url: such as "ws://127.0.0.1:PORT". topics: the server's topics, without leading slash, and their types in ROS 2's
    spelling. Raises ValueError for an invalid url, and OSError if the server cannot be reached or has gone.
    """

    def __init__(self, url: str) -> None:
        self.url, self.changed, self.lost = url, threading.Condition(), False
        self._newest: dict[str, Any] = {}
        self._kept: dict[str, deque[Any]] = {}
        rare = RareLog(logging.getLogger("uwsim.remote"))
        self._client = Client(
            url, queue=KEPT, keeps=False, left=self._end, report=lambda text: rare.warning(f"{url}: {text}")
        )
        try:
            self._client.start()
        except OSError as error:
            raise OSError(f"{url}: no rosbridge answers: {error}") from None
        self.topics = self._offered()

    def subscribe(self, topic: str, *, keep: bool = False) -> None:
        """Subscribe to a topic. keep: store the last KEPT messages instead of only the latest. Raises ValueError."""
        if topic in self._newest:
            return
        kind = self.topics.get(topic)
        if kind is None:
            raise ValueError(f"{self.url}: there is no topic '{topic}'")
        self._newest[topic] = None
        if keep:
            self._kept[topic] = deque(maxlen=KEPT)
        self._client.subscribe(topic, kind, lambda message: self._receive(topic, message))

    def newest(self, topic: str) -> Any:
        """Return the latest message on a topic. The first call subscribes to the topic. Raises ValueError."""
        self.subscribe(topic)
        if self._newest[topic] is None:
            self.wait_for(lambda: self._newest[topic] is not None, ANSWER_S, f"no message on topic '{topic}'")
        return self._newest[topic]

    def kept(self, topic: str) -> list[Any]:
        """Return the stored messages of a topic that was subscribed to with `keep`, latest last."""
        with self.changed:
            return list(self._kept[topic])

    def publish(self, topic: str, kind: str, message: Any) -> None:
        """Publish a message. Raises OSError if the connection is lost."""
        self._require()
        self._client.advertise(topic, kind)
        self._client.publish(topic, lambda: message)

    def call(self, service: str, **arguments: Any) -> dict[str, Any]:
        """Call a service and return its values. Raises ValueError, with the reason, if it failed, or OSError."""
        self._require()
        answer = self._client.ask(service, arguments, ANSWER_S)
        if not answer:
            self._require()
            raise OSError(f"{self.url}: service '{service}' does not answer")
        values = answer.get("values")
        if not answer.get("result"):
            raise ValueError(f"service '{service}': {values}")
        if not isinstance(values, dict):
            return {}
        if not values.get("success", True):
            raise ValueError(str(values.get("message") or f"service '{service}': has failed"))
        return values

    def wait_for(self, condition: Callable[[], bool], patience_s: float | None, complaint: str) -> None:
        """Wait until a condition, checked after each message, is met. Raises OSError."""
        deadline_s = None if patience_s is None else time.monotonic() + patience_s
        with self.changed:
            while not condition():
                self._require()
                if deadline_s is not None and time.monotonic() > deadline_s:
                    raise OSError(f"{self.url}: {complaint}")
                self.changed.wait(0.2)  # so that Ctrl-C takes effect

    def close(self) -> None:
        """Disconnect."""
        self._client.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Disconnect."""
        self.close()

    def _end(self) -> None:
        with self.changed:
            self.lost = True
            self.changed.notify_all()

    def _receive(self, topic: str, message: Any) -> None:
        with self.changed:
            self._newest[topic] = message
            if topic in self._kept:
                self._kept[topic].append(message)
            self.changed.notify_all()

    def _require(self) -> None:
        if self.lost:
            raise OSError(f"{self.url}: {LOST}")

    def _offered(self) -> dict[str, str]:
        values = self.call("rosapi/topics")
        found = {}
        for name, kind in zip(values.get("topics", []), values.get("types", []), strict=False):
            with suppress(ValueError):  # topics with types that are unknown here cannot be received
                found[str(name).lstrip("/")] = resolve(kind)[0]
        return found
