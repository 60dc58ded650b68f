"""The graph of topics and services, with their owners and users. It must be used on one thread only.

Like nodes in ROS, clients and the simulator are owners in the graph, identified by name.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from uwsim.bridges.doors.waiting import Room
from uwsim.bridges.rosbridge.encoding import Sample
from uwsim.bridges.rosbridge.outbox import Outbox
from uwsim.channels.ros.message_types import shortened
from uwsim.channels.ros.messages import resolve, spelled

LOGGER = logging.getLogger("uwsim.rosbridge")

Sink = Callable[[Sample], None]
Reply = Callable[[bool, Any], None]
"""Answers a call: receives whether it succeeded, and its values or the reason for the failure."""
Handler = Callable[[Any, Reply, str], None]
"""Serves a call: receives its arguments, a function to call once, now or later, with the answer, and the caller."""


def plain_name(name: object, what: str = "topic") -> str:
    """Return a name without its leading slash, so that "/scan" and "scan" are equal. Raises ValueError."""
    if not isinstance(name, str) or not 1 <= len(name) <= 256 or not name.strip("/"):
        raise ValueError(f"{what} = {shortened(name)}: must be a name")
    if not name.isprintable() or " " in name:
        raise ValueError(f"{what} = {shortened(name)}: must be a name without spaces")
    plain = name.removeprefix("/")
    if not all(plain.split("/")):  # "//clock" would be another name for /clock, with a separate queue
        raise ValueError(f"{what} = {shortened(name)}: must be a name without empty parts, such as '/rov/scan'")
    return plain


@dataclass(eq=False)
class Topic:
    """One topic. publishers: whether each owner latches. sinks: the subscribers' sinks, keyed by owner and key.

    latched: the latest latched message. latched_by: its owner, in whose room it is. count: the number of messages
    published, which is the header.seq of the next message in ROS 1.
    """

    name: str
    type: str | None = None
    publishers: dict[str, bool] = field(default_factory=dict)
    sinks: dict[tuple[str, Any], Sink] = field(default_factory=dict)
    latched: Sample | None = None
    latched_by: tuple[str, Room] | None = None
    count: int = 0

    def latch(self, sample: Sample | None, owner: tuple[str, Room] | None = None) -> None:
        """Keep a sample for later subscribers, replacing the previous one. owner: None for this process's samples."""
        if self.latched is not None and self.latched_by is not None:
            self.latched_by[1].give(self.latched.size)
        self.latched, self.latched_by = sample, owner
        if sample is not None and owner is not None:
            owner[1].take(sample.size)


@dataclass(eq=False)
class Service:
    """One service."""

    name: str
    type: str
    owner: str
    handler: Handler


class ActionHandler(Protocol):
    """The provider's side of an action."""

    def begin(self, goal: ActionGoal, arguments: Any) -> None:
        """Forward a goal. Raises ValueError if too many are in progress."""

    def cancel(self, goal: ActionGoal) -> None:
        """Request that a goal in progress be cancelled."""


class ActionGoal(Protocol):
    """A goal in progress, as seen by the client that sent it."""

    def feed_back(self, values: Any) -> None:
        """Forward feedback."""

    def finish(self, succeeded: bool, status: int, values: Any) -> None:
        """Forward the result. status: a constant of action_msgs/GoalStatus."""


@dataclass(eq=False)
class Action:
    """One action that a client offers."""

    name: str
    type: str
    owner: str
    handler: ActionHandler


class Graph:
    """Topics, services, actions and owners. All methods raise ValueError with a message that names the problem.

    on_demand: functions called with a topic name and whether the topic has subscribers, whenever that changes.
    on_joined: functions called with a topic name when it has one more subscriber, who has received nothing.
    on_leave: functions called with an owner that has left. on_abandoned: functions called with a topic name when the
    topic's last publisher has left. silence_s: returns the time since anything was received from an owner. time_ns:
    returns the graph's time. outboxes: those of the clients. report: writes a refusal into the graph's log.
    """

    def __init__(self) -> None:
        self.outboxes: set[Outbox] = set()
        self.topics: dict[str, Topic] = {}
        self.services: dict[str, Service] = {}
        self.actions: dict[str, Action] = {}
        self.nodes: dict[str, None] = {}
        self.on_demand: list[Callable[[str, bool], None]] = []
        self.on_joined: list[Callable[[str], None]] = []
        self.on_leave: list[Callable[[str], None]] = []
        self.on_abandoned: list[Callable[[str], None]] = []
        self.time_ns: Callable[[], int] = time.time_ns
        self.silence_s: Callable[[str], float] = lambda owner: 0.0
        self.report: Callable[[str], None] = lambda text: None

    def advertise(self, owner: str, name: str, type_name: str, latch: bool = False) -> Topic:
        """Register an owner as a publisher of a topic."""
        topic = self._topic(name, type_name)
        topic.publishers[owner] = latch
        return topic

    def unadvertise(self, owner: str, name: str) -> None:
        """Remove an owner from a topic's publishers.

        A latched message is removed with its owner, or with the last latching publisher.
        """
        topic = self.topics.get(plain_name(name))
        if topic is None or topic.publishers.pop(owner, None) is None:
            raise ValueError(f"topic '{name}': you do not advertise it")
        if not any(topic.publishers.values()) or (topic.latched_by is not None and topic.latched_by[0] == owner):
            topic.latch(None)
        if not topic.publishers:
            for notify in self.on_abandoned:
                notify(topic.name)
        self._forget_if_unused(topic)

    def typed_topic(self, name: Any) -> Topic:
        """Return a topic for a client to publish on. Raises ValueError if its type is unknown."""
        topic = self.topics.get(plain_name(name))
        if topic is None or topic.type is None:
            raise ValueError(f"topic '{name}': advertise it first, because its type is unknown")
        return topic

    def publish(self, topic: Topic, sample: Sample, latch: bool = False, owner: tuple[str, Room] | None = None) -> None:
        """Pass a sample to a topic's subscribers. owner: the publisher, in whose room a latched sample is."""
        sample.sequence, topic.count = topic.count, topic.count + 1
        if latch:
            topic.latch(sample, owner)
        for sink in list(topic.sinks.values()):
            sink(sample)

    def known_type(self, name: str, type_name: str | None) -> str | None:
        """Return a topic's type or, if unknown, the type given by a client. Raises ValueError if they differ."""
        resolved = resolve(type_name)[0] if type_name else None
        topic = self.topics.get(plain_name(name))
        present = topic.type if topic is not None else None
        if resolved and present and resolved != present:
            raise ValueError(f"topic '{name}' is {spelled(present, 1)}, not {type_name}")
        return present or resolved

    def subscribe(self, owner: str, key: Any, name: str, type_name: str | None, sink: Sink) -> Topic:
        """Subscribe a sink to a topic, which need not have a publisher yet."""
        topic = self._topic(name, type_name)
        was_wanted = bool(topic.sinks)
        topic.sinks[owner, key] = sink
        if topic.latched is not None:
            sink(topic.latched)
        if not was_wanted:
            self._notify_demand(topic.name, True)
        elif topic.latched is None:
            for notify in self.on_joined:
                notify(topic.name)
        return topic

    def unsubscribe(self, owner: str, key: Any, name: str) -> None:
        """Remove a sink."""
        topic = self.topics.get(plain_name(name))
        if topic is None or topic.sinks.pop((owner, key), None) is None:
            raise ValueError(f"topic '{name}': you do not subscribe to it")
        if not topic.sinks:
            self._notify_demand(topic.name, False)
        self._forget_if_unused(topic)

    def advertise_service(self, owner: str, name: str, type_name: str, handler: Handler) -> None:
        """Offer a service. Another owner's service cannot be replaced."""
        plain = plain_name(name, "service")
        present = self.services.get(plain)
        if present is not None and present.owner != owner:
            raise ValueError(f"service '{name}': {present.owner} offers it already")
        self.services[plain] = Service(plain, type_name, owner, handler)

    def unadvertise_service(self, owner: str, name: str) -> None:
        """Stop offering a service."""
        service = self.services.get(plain_name(name, "service"))
        if service is None or service.owner != owner:
            raise ValueError(f"service '{name}': you do not offer it")
        del self.services[service.name]

    def call(self, name: str, arguments: Any, reply: Reply, caller: str = "") -> None:
        """Call a service. If it does not exist or fails, the reply is False and the reason."""
        service = self.services.get(plain_name(name, "service"))
        if service is None:
            reply(False, f"service '{name}': nobody offers it")
            return
        try:
            service.handler(arguments, reply, caller)
        except ValueError as error:
            reply(False, str(error))

    def advertise_action(self, owner: str, name: str, type_name: str, handler: ActionHandler) -> None:
        """Offer an action. Another owner's action cannot be replaced."""
        plain = plain_name(name, "action")
        present = self.actions.get(plain)
        if present is not None and present.owner != owner:
            raise ValueError(f"action '{name}': {present.owner} offers it already")
        self.actions[plain] = Action(plain, type_name, owner, handler)

    def unadvertise_action(self, owner: str, name: str) -> None:
        """Stop offering an action."""
        action = self.actions.get(plain_name(name, "action"))
        if action is None or action.owner != owner:
            raise ValueError(f"action '{name}': you do not offer it")
        del self.actions[action.name]

    def leave(self, owner: str) -> None:
        """Remove an owner with all its topics, subscriptions, services and actions."""
        for topic in list(self.topics.values()):
            for key in [key for key in topic.sinks if key[0] == owner]:
                self.unsubscribe(owner, key[1], topic.name)
            if owner in topic.publishers:
                self.unadvertise(owner, topic.name)
        for service in [service for service in self.services.values() if service.owner == owner]:
            del self.services[service.name]
        for action in [action for action in self.actions.values() if action.owner == owner]:
            del self.actions[action.name]
        self.nodes.pop(owner, None)
        for notify in self.on_leave:
            notify(owner)

    def _notify_demand(self, name: str, wanted: bool) -> None:
        for notify in self.on_demand:
            notify(name, wanted)

    def _topic(self, name: str, type_name: str | None) -> Topic:
        known = self.known_type(name, type_name)
        topic = self.topics.setdefault(plain_name(name), Topic(plain_name(name)))
        topic.type = known
        return topic

    def _forget_if_unused(self, topic: Topic) -> None:
        if not topic.publishers and not topic.sinks:
            del self.topics[topic.name]
