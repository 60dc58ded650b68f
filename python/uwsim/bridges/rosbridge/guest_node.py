"""Guests in the graph: parts of this process, such as the operator's station, that are not simulators."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from uwsim.bridges.answers import Lane, outcome
from uwsim.bridges.doors.listener import post
from uwsim.bridges.rosbridge.encoding import Growing, Sample
from uwsim.bridges.rosbridge.graph import LOGGER, Graph, Reply, Topic
from uwsim.channels.calls.command_services import by_field
from uwsim.channels.guest import CatchUp, Guest, GuestService, GuestTopic

THREADS = 6


class GuestNode:
    """A guest's access to the graph (its `Node`). All methods may be called on any thread."""

    def __init__(self, guest: Guest, graph: Graph, loop: asyncio.AbstractEventLoop) -> None:
        self._guest = guest
        self._graph = graph
        self._loop = loop
        self._lane = Lane("uwsim-guest", THREADS, LOGGER)
        self._wanted: set[str] = set()
        self._newest: dict[str, Sample] = {}
        self._topics: dict[str, GuestTopic] = {}
        graph.nodes[guest.name] = None
        graph.on_demand.append(self._notice_demand)
        graph.on_leave.append(guest.left)
        for service in guest.services:
            graph.advertise_service(guest.name, service.name, service.type, partial(self._serve, service))
        guest.connect(self)

    def close(self) -> None:
        """Stop answering."""
        self._lane.close()

    def offer_topics(self, topics: Iterable[GuestTopic]) -> None:
        """Offer these topics, replacing the previous ones."""
        post(self._loop, self._advertise, {topic.name: topic for topic in topics})

    def publish(self, name: str, message: Any, time_ns: int = 0, catch_up: CatchUp | None = None) -> None:
        """Publish a message on an offered topic. catch_up: as in Channel, for messages that build on each other."""
        sample = Sample(message, time_ns) if catch_up is None else Growing(catch_up, time_ns)
        post(self._loop, self._publish, name, sample)

    def is_wanted(self, name: str) -> bool:
        """Return whether a topic has any subscribers."""
        return name in self._wanted

    def is_awaited(self, name: str) -> bool:
        """Return whether a subscriber was ready for a topic's last message, or there has been no message yet."""
        newest = self._newest.get(name)
        return newest is None or newest.is_taken

    def silence_s(self, client: str) -> float:
        """Return the time [s] since anything was received from a client."""
        return self._graph.silence_s(client)

    def _advertise(self, topics: Mapping[str, GuestTopic]) -> None:
        for name in self._topics.keys() - topics.keys():
            self._graph.unadvertise(self._guest.name, name)
            self._newest.pop(name, None)
        for name, topic in topics.items():
            try:
                self._graph.advertise(self._guest.name, name, topic.type, topic.latched)
            except ValueError as error:  # a client subscribes to it with a different type
                LOGGER.warning("%s", error)
        self._topics = dict(topics)
        self._wanted |= {name for name in topics if name in self._graph.topics and self._graph.topics[name].sinks}

    def _publish(self, name: str, sample: Sample) -> None:
        topic: Topic | None = self._graph.topics.get(name)
        known = self._topics.get(name)
        if topic is not None and known is not None and (topic.sinks or known.latched):
            self._newest[name] = sample
            self._graph.publish(topic, sample, known.latched)

    def _notice_demand(self, name: str, is_wanted: bool) -> None:
        if is_wanted:
            self._wanted.add(name)
            self._guest.demanded()
        else:
            self._wanted.discard(name)
            self._newest.pop(name, None)

    def _serve(self, service: GuestService, arguments: Any, reply: Reply, caller: str) -> None:
        if isinstance(arguments, list):
            arguments = by_field(service.name, service.fields, arguments)
        if not isinstance(arguments, dict):
            raise ValueError(f"service '{service.name}': args must be an object or a list")
        answer = partial(post, self._loop, reply)
        if not service.is_brief:
            self._lane.submit(partial(service.call, caller, arguments), answer)
            return
        found = service.call(caller, arguments)
        if isinstance(found, Future):
            found.add_done_callback(lambda done: answer(*outcome(done.result, LOGGER)))
        else:
            reply(True, found)
