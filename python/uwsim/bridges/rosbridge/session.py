"""One client's side of the protocol, without a transport: frames go in, an outbox fills.

The protocol is rosbridge v2: https://github.com/RobotWebTools/rosbridge_suite/blob/ros2/ROSBRIDGE_PROTOCOL.md
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

from uwsim.bridges.rosbridge.calls import Calls
from uwsim.bridges.rosbridge.encoding import Frame, Sample, to_json
from uwsim.bridges.rosbridge.fragments import Fragments
from uwsim.bridges.rosbridge.graph import LOGGER, Graph, Reply, plain_name
from uwsim.bridges.rosbridge.ledger import Account
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.outbox import Outbox
from uwsim.bridges.rosbridge.parse import read
from uwsim.bridges.rosbridge.subscription import CREDIT_MAX, Subscription, read_options
from uwsim.channels.message_types import shortened
from uwsim.channels.messages import Ros, from_plain, resolve

LEVELS = ("info", "warning", "error", "none")


class Made(NamedTuple):
    """A message of a type that a client publishes. size: bytes that it holds."""

    message: Any
    type: str
    size: int


class Prepared(NamedTuple):
    """A frame that has been read: its operation, or as much of it as is known, and what is wrong with it.

    spent_bytes: at most so many the operation takes.
    """

    operation: dict[str, Any]
    error: str | None = None
    spent_bytes: int = 0


class Session:
    """A client. name: in the graph. agent: its User-Agent. ros: of type names that both generations write alike.

    wake: called when the outbox has something to send; give_up: with the reason when the client must be disconnected.
    A session that is given up does nothing more, and keeps nothing; close() must follow. roslibpy knows neither status
    (unless it asks by set_level) nor png: both are kept from it.
    """

    operations: ClassVar[dict[str, Callable[[Session, dict[str, Any]], None]]]

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
        self.ros: Ros = ros
        self.limits = limits or Limits()
        self._end = give_up
        self._account = Account(graph.ledger, self.limits.client_bytes, self._give_up)
        self.outbox = Outbox(self.limits, self._account, clock, wake)
        self._is_roslibpy = agent.startswith("AutobahnPython")
        self._level = "none" if self._is_roslibpy else "error"
        self._fragments = Fragments(self.limits, self._account)
        self._calls = Calls(self.limits, self._account, self.outbox)
        self._advertised: dict[str, bool] = {}  # topics by plain name: latched
        self._subscriptions: dict[str, Subscription] = {}  # by the name as sent
        self._services: set[str] = set()
        self._spent_bytes = 0  # of the present operation
        self._whole: str | None = None  # a message put together from fragments
        self._is_over = False
        graph.on_leave.append(self._calls.forget_caller)
        graph.nodes[name] = None

    def receive(self, frame: Frame) -> None:
        """Do what a frame asks for. What is wrong with it is said by status; raises nothing."""
        whole = self.perform(self.prepare(frame))
        if whole is not None:
            self.perform(self.prepare(whole, is_whole=True))

    def prepare(self, frame: Frame, pause: Callable[[], None] | None = None, *, is_whole: bool = False) -> Prepared:
        """Read a frame, on any thread; raises nothing. pause: called between slices of the work.

        is_whole: it has come in fragments.
        """
        operation: dict[str, Any] = {}
        try:
            if len(frame) > self.limits.frame_bytes:
                raise ValueError(f"frame: {len(frame)} bytes: must be {self.limits.frame_bytes} at most")
            operation, meter = read(frame, self.limits, pause)
            if is_whole and operation.get("op") == "fragment":
                raise ValueError("fragment: holds a fragment")
            if operation.get("op") == "publish":
                kind = self.graph.typed_topic(operation.get("topic")).type
                assert kind is not None
                message = from_plain(kind, operation.pop("msg", {}), meter=meter)
                operation["msg"] = Made(message, kind, meter.made_bytes + sys.getsizeof(frame))
        except ValueError as error:
            return Prepared(operation, str(error))
        except Exception:
            LOGGER.exception("%s: a frame that we did not foresee", self.name)
            return Prepared(operation, "the server failed at this operation")
        return Prepared(operation, None, int(meter.spent_bytes))

    def perform(self, prepared: Prepared) -> Frame | None:
        """Do what a frame asks for, on the graph's thread. Return what its fragment has made whole."""
        if self._is_over:
            return None
        try:
            if prepared.error is not None:
                raise ValueError(prepared.error)
            self._spent_bytes = prepared.spent_bytes
            self._perform(prepared.operation)
        except ValueError as error:
            self._complain(str(error), prepared.operation)
        except Exception:
            LOGGER.exception("%s: a frame that we did not foresee", self.name)
            self._complain("the server failed at this operation", prepared.operation)
        whole, self._whole = self._whole, None
        return whole

    def close(self) -> None:
        """Leave the graph; whoever waits for this client's services is told."""
        self._is_over = True
        self.graph.on_leave.remove(self._calls.forget_caller)
        self.graph.leave(self.name)
        self._calls.close(self.name)
        self.outbox.shut()
        self._account.close()

    def _give_up(self, reason: str) -> None:
        """Let go of a client that costs too much."""
        if not self._is_over:
            self._is_over = True
            LOGGER.warning("%s: disconnected: %s", self.name, reason)
            self.outbox.shut()
            self._account.close()
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
        perform(self, operation)

    def _wrong_with(self, identity: object) -> str | None:
        """Return what is wrong with an id, in words; None if answers can carry it."""
        if not isinstance(identity, str | int | None):
            return f"id = {shortened(identity)}: must be a string"
        if len(str(identity)) > self.limits.identity:
            return f"id: {len(str(identity))} characters: must be {self.limits.identity} at most"
        if any("\ud800" <= character <= "\udfff" for character in str(identity)):
            return f"id = {shortened(identity)}: half a surrogate pair: must be Unicode text"
        return None

    def _complain(self, message: str, operation: dict[str, Any], level: str = "error") -> None:
        LOGGER.info("%s: %s", self.name, message)
        if LEVELS.index(level) >= LEVELS.index(self._level):
            status: dict[str, Any] = {"op": "status", "level": level, "msg": message}
            identity = operation.get("id")
            if isinstance(identity, str | int) and self._wrong_with(identity) is None:
                status["id"] = identity
            self.outbox.reply(to_json(status))

    def _check_room(self) -> None:
        if len(self._advertised) + len(self._subscriptions) + len(self._services) >= self.limits.names:
            raise ValueError(f"names: you have {self.limits.names} topics and services, which is the most")
        if len(self.graph.topics) + len(self.graph.services) >= self.limits.all_names:
            raise ValueError(f"names: there are {self.limits.all_names} topics and services, which is the most")

    # Topics

    def _advertise(self, operation: dict[str, Any]) -> None:
        name, latch = plain_name(operation.get("topic")), operation.get("latch") is True
        self._check_room()
        self.graph.advertise(self.name, name, resolve(operation.get("type"))[0], latch)
        self._advertised[name] = latch

    def _unadvertise(self, operation: dict[str, Any]) -> None:
        name = plain_name(operation.get("topic"))
        self._advertised.pop(name, None)
        self.graph.unadvertise(self.name, name)

    def _publish(self, operation: dict[str, Any]) -> None:
        """Publish; a topic that has a type need not be advertised."""
        topic, made = self.graph.typed_topic(operation.get("topic")), operation["msg"]
        if topic.type != made.type:
            raise ValueError(f"topic '{topic.name}': its type has just changed from {made.type} to {topic.type}")
        if topic.name not in self._advertised:
            self._advertise({"topic": topic.name, "type": topic.type, "latch": operation.get("latch")})
        latch = self._advertised[topic.name] or operation.get("latch") is True
        sample = Sample(made.message, time.time_ns(), made.size)
        if latch and not self._account.has_room(sample.size):
            raise ValueError(f"topic '{topic.name}': no room to latch it: too much is kept for you, or for all clients")
        self.graph.publish(topic, sample, latch, (self.name, self._account))

    def _subscribe(self, operation: dict[str, Any]) -> None:
        name, type_name = operation.get("topic"), operation.get("type") or None
        options = read_options(operation, self.limits)
        plain_name(name)
        assert isinstance(name, str)
        ros = (resolve(type_name)[1] if type_name else None) or self.ros
        known = self.graph.known_type(name, type_name)
        present = self._subscriptions.get(name)
        if present is None:
            self._check_room()
            subscription = Subscription(name, ros)
        else:
            subscription = present
        identity = operation.get("id")
        if identity not in subscription.ids and len(subscription.ids) >= self.limits.ids:
            raise ValueError(f"topic '{name}': you have {self.limits.ids} subscriptions to it, which is the most")
        subscription.ids[identity] = options
        self.outbox.open(name, subscription.mailbox(known, png=not self._is_roslibpy))
        self._subscriptions[name] = subscription
        self.graph.subscribe(self.name, name, name, type_name, lambda sample: self.outbox.put(name, sample))

    def _unsubscribe(self, operation: dict[str, Any]) -> None:
        """End one of a topic's subscriptions by its id, or all of them."""
        name, identity = operation.get("topic"), operation.get("id")
        plain_name(name)
        subscription = self._subscriptions.get(name)  # type: ignore[arg-type]
        if subscription is None:
            raise ValueError(f"topic '{name}': you do not subscribe to it")
        if identity in subscription.ids:
            del subscription.ids[identity]
        else:
            subscription.ids.clear()
        if not subscription.ids:
            self._drop_subscription(subscription.topic)
            self.graph.unsubscribe(self.name, subscription.topic, subscription.topic)

    def _acknowledge(self, operation: dict[str, Any]) -> None:
        """Ours, not rosbridge's: the client has dealt with messages of a subscription with credit."""
        name, count = operation.get("topic"), operation.get("count", 1)
        if not isinstance(name, str) or name not in self._subscriptions:
            raise ValueError(f"topic = {shortened(name)}: you do not subscribe to it")
        if type(count) is not int or not 1 <= count <= CREDIT_MAX:
            raise ValueError(f"ack.count = {shortened(count)}: must be in [1, {CREDIT_MAX}]")
        self.outbox.acknowledge(name, count)

    def _drop_subscription(self, name: str) -> None:
        del self._subscriptions[name]
        self.outbox.close(name)

    # Services

    def _call_service(self, operation: dict[str, Any]) -> None:
        name, identity = operation.get("service"), operation.get("id")
        response: dict[str, Any] = {"op": "service_response"}
        if identity is not None:
            response["id"] = identity
        response["service"] = name if isinstance(name, str) and len(name) <= 256 else shortened(name)
        reply = self._calls.make(response, self._spent_bytes)
        arguments = operation.get("args")
        try:
            self.graph.call(name, {} if arguments in (None, []) else arguments, reply, self.name)  # type: ignore[arg-type]
        except ValueError as error:  # not even a name
            reply(False, str(error))

    def _advertise_service(self, operation: dict[str, Any]) -> None:
        name, type_name = operation.get("service"), operation.get("type", "")
        plain = plain_name(name, "service")
        if not isinstance(type_name, str) or len(type_name) > 200:
            raise ValueError(f"type = {shortened(type_name)}: must be the name of a service's type")
        self._check_room()

        def serve(arguments: Any, reply: Reply, caller: str) -> None:
            self._calls.receive(str(name), arguments, reply, caller)

        self.graph.advertise_service(self.name, plain, type_name, serve)
        self._services.add(plain)

    def _unadvertise_service(self, operation: dict[str, Any]) -> None:
        name = plain_name(operation.get("service"), "service")
        self._services.discard(name)
        self.graph.unadvertise_service(self.name, name)

    def _service_response(self, operation: dict[str, Any]) -> None:
        succeeded = operation.get("result", True) is not False
        self._calls.respond(operation.get("id"), succeeded, operation.get("values", {}))

    # The rest

    def _fragment(self, operation: dict[str, Any]) -> None:
        self._whole = self._fragments.add(operation)

    def _set_level(self, operation: dict[str, Any]) -> None:
        level = operation.get("level")
        if level not in LEVELS:
            raise ValueError(f"level = {shortened(level)}: must be one of {', '.join(LEVELS)}")
        self._level = level

    def _status(self, operation: dict[str, Any]) -> None:
        message = operation.get("msg")
        LOGGER.info("%s says: %s", self.name, message[:500] if isinstance(message, str) else shortened(message))


Session.operations = {
    "advertise": Session._advertise,
    "unadvertise": Session._unadvertise,
    "publish": Session._publish,
    "subscribe": Session._subscribe,
    "unsubscribe": Session._unsubscribe,
    "ack": Session._acknowledge,
    "call_service": Session._call_service,
    "advertise_service": Session._advertise_service,
    "unadvertise_service": Session._unadvertise_service,
    "service_response": Session._service_response,
    "fragment": Session._fragment,
    "set_level": Session._set_level,
    "status": Session._status,
}
