"""A session of the protocol with one client. It handles frames and fills an outbox, without a transport.

The protocol is rosbridge v2: https://github.com/RobotWebTools/rosbridge_suite/blob/ros2/ROSBRIDGE_PROTOCOL.md
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

from uwsim.bridges.doors.conversation import Frame
from uwsim.bridges.rosbridge.actions import Actions
from uwsim.bridges.rosbridge.calls import Calls
from uwsim.bridges.rosbridge.encoding import Sample, from_png, held_bytes, to_json
from uwsim.bridges.rosbridge.fragments import Fragments
from uwsim.bridges.rosbridge.graph import LOGGER, Graph
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.names import Names
from uwsim.bridges.rosbridge.outbox import Outbox
from uwsim.bridges.rosbridge.parse import read
from uwsim.bridges.rosbridge.topics import Made, Topics, stamp
from uwsim.channels.ros.message_types import is_unicode, shortened
from uwsim.channels.ros.messages import Ros, from_plain

Perform = Callable[[dict[str, Any]], None]
"""Performs an operation."""
LEVELS = ("info", "warning", "error", "none")


class Prepared(NamedTuple):
    """A decoded frame: its operation, or the readable part of the operation together with the error.

    spent_bytes: the memory of an operation that may be kept.
    """

    operation: dict[str, Any]
    error: str | None = None
    spent_bytes: int = 0


class Session:
    """A session with one client. name: its name in the graph. agent: its User-Agent.

    ros: the ROS generation assumed for type names that are spelled the same in both.

    wake: called when the outbox has a frame to send. give_up: called with the reason when the client must be
    disconnected. The session then does nothing more and stores nothing, and close() must follow. Since roslibpy
    supports neither status (unless requested by set_level) nor png, neither is sent to it.
    """

    _actions: Actions
    _calls: Calls
    _topics: Topics

    operations: ClassVar[dict[str, Callable[[Session], Perform]]] = {
        "advertise": lambda session: session._topics.advertise,
        "unadvertise": lambda session: session._topics.unadvertise,
        "publish": lambda session: session._topics.publish,
        "subscribe": lambda session: session._topics.subscribe,
        "unsubscribe": lambda session: session._topics.unsubscribe,
        "ack": lambda session: session._topics.acknowledge,
        "call_service": lambda session: session._calls.call_service,
        "advertise_service": lambda session: session._calls.advertise_service,
        "unadvertise_service": lambda session: session._calls.unadvertise_service,
        "service_response": lambda session: session._calls.respond,
        "advertise_action": lambda session: session._actions.advertise,
        "unadvertise_action": lambda session: session._actions.unadvertise,
        "send_action_goal": lambda session: session._actions.send_goal,
        "cancel_action_goal": lambda session: session._actions.cancel_goal,
        "action_feedback": lambda session: session._actions.feed_back,
        "action_result": lambda session: session._actions.finish,
        "fragment": lambda session: session._fragment,
        "png": lambda session: session._png,
        "set_level": lambda session: session._set_level,
        "set_status_level": lambda session: session._set_level,
        "status": lambda session: session._status,
    }

    def __init__(
        self,
        graph: Graph,
        name: str,
        *,
        ros: Ros = 1,
        agent: str = "",
        limits: Limits | None = None,
        clock: Callable[[], float] = time.monotonic,
        wake: Callable[[], None] = lambda: None,
        give_up: Callable[[str], None] = lambda reason: None,
    ) -> None:
        self.graph = graph
        self.name = name
        self.limits = limits or Limits()
        self._end = give_up
        self.outbox = Outbox(self.limits, clock, wake, self._give_up)
        is_roslibpy = agent.startswith("AutobahnPython")
        self._level = "none" if is_roslibpy else "error"
        self._fragments = Fragments(self.limits, self.outbox.kept)
        shared = self.limits, self.outbox
        names = Names(graph, self.limits)
        self._calls = Calls(graph, name, names, *shared)
        self._actions = Actions(graph, name, names, *shared)
        self._topics = Topics(graph, name, names, *shared, ros=ros, png=not is_roslibpy)
        self._whole: str | None = None  # a message assembled from fragments
        self._is_over = False
        graph.nodes[name] = None
        graph.outboxes.add(self.outbox)
        self._share()

    def receive(self, frame: Frame) -> None:
        """Handle a frame. Errors are reported to the client as a status, never raised."""
        whole = self.perform(self.prepare(frame))
        if whole is not None:
            self.perform(self.prepare(whole, is_whole=True))

    def prepare(self, frame: Frame, *, is_whole: bool = False) -> Prepared:
        """Decode a frame, on any thread. Errors are never raised. is_whole: whether it was assembled from fragments."""
        operation: dict[str, Any] = {}
        spent_bytes = 0
        try:
            if len(frame) > self.limits.frame_bytes:
                raise ValueError(f"frame: {len(frame)} bytes: must be {self.limits.frame_bytes} at most")
            operation = read(frame, self.limits)
            if is_whole and operation.get("op") in ("fragment", "png"):
                raise ValueError(f"{operation['op']}: within a fragmented or compressed message")
            if operation.get("op") == "publish":
                kind = self.graph.typed_topic(operation.get("topic")).type
                assert kind is not None
                given = operation.pop("msg", {})
                message = from_plain(kind, given, most=self.limits.objects)
                stamp(message, given, self.graph.time_ns)
                sample = Sample(message, time.time_ns())
                operation["msg"] = Made(sample, kind, sample.size)
            elif operation.get("op") in ("call_service", "send_action_goal"):
                spent_bytes = held_bytes(operation)
        except ValueError as error:
            return Prepared(operation, str(error))
        except Exception:
            LOGGER.exception("%s: a frame that we did not foresee", self.name)
            return Prepared(operation, "the server failed at this operation")
        return Prepared(operation, None, spent_bytes)

    def perform(self, prepared: Prepared) -> Frame | None:
        """Handle a decoded frame, on the graph's thread.

        Return the message that is completed by its fragment, if any.
        """
        if self._is_over:
            return None
        try:
            if prepared.error is not None:
                raise ValueError(prepared.error)
            self._calls.spent_bytes = self._actions.spent_bytes = prepared.spent_bytes
            self._perform(prepared.operation)
        except ValueError as error:
            self._complain(str(error), prepared.operation)
        except Exception:
            LOGGER.exception("%s: a frame that we did not foresee", self.name)
            self._complain("the server failed at this operation", prepared.operation)
        whole, self._whole = self._whole, None
        return whole

    def close(self) -> None:
        """Leave the graph; calls to this client's services fail."""
        self._is_over = True
        self.graph.leave(self.name)
        self._calls.close()
        self._actions.close()
        self.outbox.shut()
        self.graph.outboxes.discard(self.outbox)
        self._share()

    def _share(self) -> None:
        """Share the room among the clients that are here."""
        for outbox in list(self.graph.outboxes):
            outbox.share(len(self.graph.outboxes))

    def _give_up(self, reason: str) -> None:
        """Disconnect a client that uses too many resources."""
        if not self._is_over:
            self._is_over = True
            self.outbox.shut()
            self._end(reason)

    def _perform(self, operation: dict[str, Any]) -> None:
        perform = self.operations.get(operation["op"]) if isinstance(operation.get("op"), str) else None
        if perform is None:
            known = ", ".join(self.operations)
            raise ValueError(f"op = {shortened(operation.get('op'))}: unknown; there are: {known}")
        identity = operation.get("id")
        wrong = self._wrong_with(identity)
        if wrong is not None:
            raise ValueError(wrong)
        perform(self)(operation)

    def _wrong_with(self, identity: object) -> str | None:
        """Return a text with the problem of an id, or None if answers can carry the id."""
        if not isinstance(identity, str | int | None):
            return f"id = {shortened(identity)}: must be a string"
        if isinstance(identity, int) and not -(1 << 63) <= identity < 1 << 63:
            return "id: an integer beyond 64 bits: must be a string"  # even formatting the id takes too long
        if len(str(identity)) > self.limits.identity:
            return f"id: {len(str(identity))} characters: must be {self.limits.identity} at most"
        if not is_unicode(str(identity)):
            return f"id = {shortened(identity)}: half a surrogate pair: must be Unicode text"
        return None

    def _complain(self, message: str, operation: dict[str, Any], level: str = "error") -> None:
        LOGGER.info("%s: %s", self.name, message)
        self.graph.report(f"{self.name}: {message}")
        if LEVELS.index(level) >= LEVELS.index(self._level):
            status: dict[str, Any] = {"op": "status", "level": level, "msg": message}
            identity = operation.get("id")
            if isinstance(identity, str | int) and self._wrong_with(identity) is None:
                status["id"] = identity
            self.outbox.reply(to_json(status))

    def _fragment(self, operation: dict[str, Any]) -> None:
        self._whole = self._fragments.add(operation)

    def _png(self, operation: dict[str, Any]) -> None:
        data = self._fragments.add(operation) if "total" in operation else operation.get("data")
        if data is None:
            return
        if not isinstance(data, str):
            raise ValueError(f"png.data = {shortened(data)}: must be a string")
        self._whole = from_png(data, self.limits.frame_bytes)

    def _set_level(self, operation: dict[str, Any]) -> None:
        level = operation.get("level")
        if level not in LEVELS:
            raise ValueError(f"level = {shortened(level)}: must be one of {', '.join(LEVELS)}")
        self._level = level

    def _status(self, operation: dict[str, Any]) -> None:
        message = operation.get("msg")
        LOGGER.info("%s says: %s", self.name, message[:500] if isinstance(message, str) else shortened(message))
