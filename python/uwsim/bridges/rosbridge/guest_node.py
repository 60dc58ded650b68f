"""A part of this process that is no simulator as a peer in the graph, such as the operator's station."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from uwsim.bridges.rosbridge.encoding import Growing, Sample
from uwsim.bridges.rosbridge.graph import LOGGER, Graph, Handler, Reply, Topic
from uwsim.channels.guest import CatchUp, Guest, GuestService, GuestTopic

THREADS = 6


class GuestNode:
    """A guest's end of the graph, its `Node`; the methods of that may be called on any thread."""

    def __init__(self, guest: Guest, graph: Graph, loop: asyncio.AbstractEventLoop) -> None:
        self._guest = guest
        self._graph = graph
        self._loop = loop
        self._pool = ThreadPoolExecutor(THREADS, thread_name_prefix="uwsim-guest")
        self._wanted: set[str] = set()
        self._newest: dict[str, Sample] = {}
        self._topics: dict[str, GuestTopic] = {}
        graph.nodes[guest.name] = None
        graph.on_demand.append(self._notice_demand)
        graph.on_leave.append(guest.left)
        for service in guest.services:
            graph.advertise_service(guest.name, service.name, service.type, self._server(service))
        guest.connect(self)

    def close(self) -> None:
        """Answer nothing more."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def offer_topics(self, topics: Iterable[GuestTopic]) -> None:
        """Offer these topics, instead of those before."""
        self._on_loop(self._advertise, {topic.name: topic for topic in topics})

    def publish(self, name: str, message: Any, time_ns: int = 0, catch_up: CatchUp | None = None) -> None:
        """Publish a message on a topic that is offered. catch_up: as a Channel's, of messages that build up."""
        sample = Sample(message, time_ns) if catch_up is None else Growing(catch_up, time_ns)
        self._on_loop(self._publish, name, sample)

    def is_wanted(self, name: str) -> bool:
        """Return whether anybody subscribes to a topic."""
        return name in self._wanted

    def is_awaited(self, name: str) -> bool:
        """Return whether somebody was ready for the last message of a topic, or there has been none."""
        newest = self._newest.get(name)
        return newest is None or newest.is_taken

    def silence_s(self, client: str) -> float:
        """Return for how long [s] nothing at all has come from a client."""
        return self._graph.silence_s(client)

    def _advertise(self, topics: Mapping[str, GuestTopic]) -> None:
        for name in self._topics.keys() - topics.keys():
            self._graph.unadvertise(self._guest.name, name)
            self._newest.pop(name, None)
        for name, topic in topics.items():
            try:
                self._graph.advertise(self._guest.name, name, topic.type, topic.latched)
            except ValueError as error:  # a client subscribes to it as something else
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

    def _server(self, service: GuestService) -> Handler:
        def serve(arguments: Any, reply: Reply, caller: str) -> None:
            if not isinstance(arguments, dict):
                raise ValueError(f"service '{service.name}': args must be an object")
            if service.is_brief:
                self._answer(service.call(caller, arguments), reply)
            else:
                self._pool.submit(service.call, caller, arguments).add_done_callback(
                    lambda done: self._on_loop(_pass_on, done, reply)
                )

        return serve

    def _answer(self, answer: dict[str, Any] | Future[dict[str, Any]], reply: Reply) -> None:
        if isinstance(answer, Future):
            answer.add_done_callback(lambda done: self._on_loop(_pass_on, done, reply))
        else:
            reply(True, answer)

    def _on_loop(self, function: Callable[..., None], *arguments: Any) -> None:
        try:
            self._loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:  # the loop has ended
            LOGGER.debug("%s: the server has stopped", self._guest.name)


def _pass_on(done: Future[Any], reply: Reply) -> None:
    if done.cancelled():
        reply(False, "the server stops")
        return
    error = done.exception()
    if error is None:
        reply(True, done.result())
        return
    if not isinstance(error, ValueError | RuntimeError):
        LOGGER.error("a service failed", exc_info=error)
    reply(False, str(error) or type(error).__name__)
