"""The topics that one client publishes or subscribes to."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from uwsim.bridges.rosbridge.encoding import Sample
from uwsim.bridges.rosbridge.graph import Graph, plain_name
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.names import Names
from uwsim.bridges.rosbridge.outbox import Outbox
from uwsim.bridges.rosbridge.subscription import CREDIT_MAX, Subscription, read_options
from uwsim.channels.ros import build
from uwsim.channels.ros.message_types import shortened
from uwsim.channels.ros.messages import Ros, resolve

Operation = dict[str, Any]


class Made(NamedTuple):
    """A sample built from a client's message, and its size, which takes a while to measure."""

    sample: Sample
    type: str
    size: int


def stamp(message: Any, given: Any, time_ns: Callable[[], int]) -> None:
    """Set the time of a message if the client has left it out of the header, as rosbridge does."""
    header = getattr(message, "header", None)
    sent = given.get("header") if isinstance(given, dict) else None
    if hasattr(header, "stamp") and not (isinstance(sent, dict) and "stamp" in sent):
        header.stamp = build.time(time_ns())  # type: ignore[union-attr]


class Topics:
    """A client's topics. name: its name in the graph. png: whether it can decode PNG-compressed messages."""

    def __init__(
        self,
        graph: Graph,
        name: str,
        names: Names,
        limits: Limits,
        outbox: Outbox,
        *,
        ros: Ros,
        png: bool,
    ) -> None:
        self._graph, self._name, self._names = graph, name, names
        self._limits, self._outbox = limits, outbox
        self._ros: Ros = ros
        self._png = png

    def advertise(self, operation: Operation) -> None:
        """Register the client as a publisher of a topic."""
        name, latch = plain_name(operation.get("topic")), operation.get("latch") is True
        self._names.check_room()
        self._graph.advertise(self._name, name, resolve(operation.get("type"))[0], latch)
        self._names.advertised[name] = latch

    def unadvertise(self, operation: Operation) -> None:
        """Remove the client as a publisher of a topic."""
        name = plain_name(operation.get("topic"))
        self._names.advertised.pop(name, None)
        self._graph.unadvertise(self._name, name)

    def publish(self, operation: Operation) -> None:
        """Publish a client's message. A topic with a known type need not be advertised first."""
        topic, made = self._graph.typed_topic(operation.get("topic")), operation["msg"]
        if topic.type != made.type:
            raise ValueError(f"topic '{topic.name}': its type has just changed from {made.type} to {topic.type}")
        if topic.name not in self._names.advertised:
            self.advertise({"topic": topic.name, "type": topic.type, "latch": operation.get("latch")})
        latch = self._names.advertised[topic.name] or operation.get("latch") is True
        if latch and not self._outbox.kept.has(made.size):
            raise ValueError(f"topic '{topic.name}': no room to latch it: too much is kept for you")
        self._graph.publish(topic, made.sample, latch, (self._name, self._outbox.kept))

    def subscribe(self, operation: Operation) -> None:
        """Subscribe the client to a topic, combining this id's options with those of earlier ids."""
        name, type_name = operation.get("topic"), operation.get("type") or None
        options = read_options(operation, self._limits)
        plain_name(name)
        assert isinstance(name, str)
        ros = (resolve(type_name)[1] if type_name else None) or self._ros
        known = self._graph.known_type(name, type_name)
        subscription = self._names.subscriptions.get(name)
        if subscription is None:
            self._names.check_room()
            subscription = Subscription(name, ros)
        identity = operation.get("id")
        if identity not in subscription.ids and len(subscription.ids) >= self._limits.ids:
            raise ValueError(f"topic '{name}': you have {self._limits.ids} subscriptions to it, the maximum")
        subscription.ids[identity] = options
        self._outbox.open(name, subscription.mailbox(known, self._outbox.room, png=self._png))
        self._names.subscriptions[name] = subscription
        self._graph.subscribe(self._name, name, name, type_name, lambda sample: self._outbox.put(name, sample))

    def unsubscribe(self, operation: Operation) -> None:
        """End the subscription to a topic with this id, or all subscriptions to the topic if there is no id."""
        name, identity = operation.get("topic"), operation.get("id")
        plain_name(name)
        subscription = self._names.subscriptions.get(name)  # type: ignore[arg-type]
        if subscription is None:
            raise ValueError(f"topic '{name}': you do not subscribe to it")
        if identity is None:
            subscription.ids.clear()
        elif identity not in subscription.ids:
            raise ValueError(f"topic '{name}': you have no subscription with id {shortened(identity)}")
        subscription.ids.pop(identity, None)
        if not subscription.ids:
            del self._names.subscriptions[subscription.topic]
            self._outbox.close(subscription.topic)
            self._graph.unsubscribe(self._name, subscription.topic, subscription.topic)

    def acknowledge(self, operation: Operation) -> None:
        """Restore credit after the client has processed messages from a subscription.

        This operation is an extension to rosbridge.
        """
        name, count = operation.get("topic"), operation.get("count", 1)
        if not isinstance(name, str) or name not in self._names.subscriptions:
            raise ValueError(f"topic = {shortened(name)}: you do not subscribe to it")
        if type(count) is not int or not 1 <= count <= CREDIT_MAX:
            raise ValueError(f"ack.count = {shortened(count)}: must be in [1, {CREDIT_MAX}]")
        self._outbox.acknowledge(name, count)
