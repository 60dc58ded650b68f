"""One client's side of the protocol, without a transport: frames go in, an outbox fills.

The protocol is rosbridge v2: https://github.com/RobotWebTools/rosbridge_suite/blob/ros2/ROSBRIDGE_PROTOCOL.md
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import Any

from uwsim.bridges.rosbridge.encoding import Frame, Sample, to_json
from uwsim.bridges.rosbridge.fragments import Fragments
from uwsim.bridges.rosbridge.graph import LOGGER, Graph, Reply, plain_name
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.outbox import Outbox
from uwsim.bridges.rosbridge.parse import parse
from uwsim.bridges.rosbridge.subscription import CREDIT_MAX, Subscription, read_options
from uwsim.channels.messages import Ros, resolve

LEVELS = ("info", "warning", "error", "none")


class Session:
    """A client. name: in the graph. agent: its User-Agent. ros: of type names that both generations write alike.

    wake: called when the outbox has something to send; give_up: when the client must be disconnected. roslibpy knows
    neither status (unless it asks by set_level) nor png: both are kept from it.
    """

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
        give_up: Callable[[], None] = lambda: None,
    ) -> None:
        self.graph = graph
        self.name = name
        self.ros: Ros = ros
        self.limits = limits or Limits()
        self.outbox = Outbox(self.limits.replies, clock, wake, give_up)
        self._is_roslibpy = agent.startswith("AutobahnPython")
        self._level = "none" if self._is_roslibpy else "error"
        self._fragments = Fragments(self.limits)
        self._advertised: dict[str, bool] = {}  # topics by plain name: latched
        self._subscriptions: dict[str, Subscription] = {}  # by the name as sent
        self._calls: dict[str, Reply] = {}  # of this client's services, not answered yet
        self._services: set[str] = set()
        self._numbers = itertools.count(1)
        self._closed = False
        self.operations: dict[str, Callable[[dict[str, Any]], None]] = {
            "advertise": self._advertise,
            "unadvertise": self._unadvertise,
            "publish": self._publish,
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
            "ack": self._acknowledge,
            "call_service": self._call_service,
            "advertise_service": self._advertise_service,
            "unadvertise_service": self._unadvertise_service,
            "service_response": self._service_response,
            "fragment": self._fragment,
            "set_level": self._set_level,
            "status": self._status,
        }
        graph.nodes[name] = None

    def receive(self, frame: Frame) -> None:
        """Do what a frame asks for. What is wrong with it is said by status; raises nothing."""
        operation: dict[str, Any] = {}
        try:
            if len(frame) > self.limits.frame_bytes:
                raise ValueError(f"frame: {len(frame)} bytes: must be {self.limits.frame_bytes} at most")
            operation = parse(frame, self.limits.nesting)
            self._perform(operation)
        except ValueError as error:
            self._complain(str(error), operation)
        except Exception:
            LOGGER.exception("%s: a frame that we did not foresee", self.name)
            self._complain("the server failed at this operation", operation)

    def close(self) -> None:
        """Leave the graph; whoever waits for this client's services is told."""
        self._closed = True
        self.graph.leave(self.name)
        calls, self._calls = self._calls, {}
        for reply in calls.values():
            reply(False, f"{self.name}, who offers the service, has left")

    def _perform(self, operation: dict[str, Any]) -> None:
        perform = self.operations.get(operation["op"]) if isinstance(operation.get("op"), str) else None
        if perform is None:
            known = ", ".join(self.operations)
            raise ValueError(f"op = {operation.get('op')!r:.40}: unknown; there are: {known}")
        if not isinstance(operation.get("id"), str | int | None):
            raise ValueError(f"id = {operation['id']!r:.40}: must be a string")
        perform(operation)

    def _complain(self, message: str, operation: dict[str, Any], level: str = "error") -> None:
        LOGGER.info("%s: %s", self.name, message)
        if LEVELS.index(level) >= LEVELS.index(self._level):
            status = {"op": "status", "level": level, "msg": message}
            if isinstance(operation.get("id"), str | int):
                status["id"] = operation["id"]
            self.outbox.reply(to_json(status))

    def _check_room(self) -> None:
        if len(self._advertised) + len(self._subscriptions) + len(self._services) >= self.limits.names:
            raise ValueError(f"names: you have {self.limits.names} topics and services, which is the most")

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
        topic, message = self.graph.read_message(self.name, operation.get("topic"), operation.get("msg", {}))  # type: ignore[arg-type]
        if topic.name not in self._advertised:
            self._advertise({"topic": topic.name, "type": topic.type, "latch": operation.get("latch")})
        latch = self._advertised[topic.name] or operation.get("latch") is True
        self.graph.publish(topic, Sample(message, time.time_ns()), latch)

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
        subscription.ids[operation.get("id")] = options
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
            raise ValueError(f"topic = {name!r:.40}: you do not subscribe to it")
        if type(count) is not int or not 1 <= count <= CREDIT_MAX:
            raise ValueError(f"ack.count = {count!r:.40}: must be in [1, {CREDIT_MAX}]")
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
        response["service"] = name

        def reply(succeeded: bool, values: Any) -> None:
            if not self._closed:
                self._respond(response | {"values": values, "result": succeeded})

        arguments = operation.get("args")
        try:
            self.graph.call(name, {} if arguments in (None, []) else arguments, reply, self.name)  # type: ignore[arg-type]
        except ValueError as error:  # not even a name
            reply(False, str(error))

    def _respond(self, response: dict[str, Any]) -> None:
        try:
            frame = to_json(response)
        except ValueError as error:
            frame = to_json(response | {"values": f"values: {error}", "result": False})
        self.outbox.reply(frame)

    def _advertise_service(self, operation: dict[str, Any]) -> None:
        name, type_name = operation.get("service"), operation.get("type", "")
        plain = plain_name(name, "service")
        if not isinstance(type_name, str) or len(type_name) > 200:
            raise ValueError(f"type = {type_name!r:.40}: must be the name of a service's type")
        self._check_room()

        def serve(arguments: Any, reply: Reply, caller: str) -> None:
            if len(self._calls) >= self.limits.open_calls:
                raise ValueError(f"service '{name}': {self.limits.open_calls} calls wait for its answer")
            identity = f"service_request:{name}:{next(self._numbers)}"
            call = {"op": "call_service", "id": identity, "service": name, "args": arguments}
            frame = to_json(call)
            self._calls[identity] = reply
            self.outbox.reply(frame)

        self.graph.advertise_service(self.name, plain, type_name, serve)
        self._services.add(plain)

    def _unadvertise_service(self, operation: dict[str, Any]) -> None:
        name = plain_name(operation.get("service"), "service")
        self._services.discard(name)
        self.graph.unadvertise_service(self.name, name)

    def _service_response(self, operation: dict[str, Any]) -> None:
        identity = operation.get("id")
        reply = self._calls.pop(identity, None) if isinstance(identity, str) else None
        if reply is None:
            raise ValueError(f"service_response.id = {identity!r:.60}: no such call waits for an answer")
        reply(operation.get("result", True) is not False, operation.get("values", {}))

    # The rest

    def _fragment(self, operation: dict[str, Any]) -> None:
        whole = self._fragments.add(operation)
        if whole is not None:
            inner = parse(whole, self.limits.nesting)
            if inner.get("op") == "fragment":
                raise ValueError("fragment: holds a fragment")
            self._perform(inner)

    def _set_level(self, operation: dict[str, Any]) -> None:
        level = operation.get("level")
        if level not in LEVELS:
            raise ValueError(f"level = {level!r:.40}: must be one of {', '.join(LEVELS)}")
        self._level = level

    def _status(self, operation: dict[str, Any]) -> None:
        LOGGER.info("%s says: %s", self.name, str(operation.get("msg"))[:500])
