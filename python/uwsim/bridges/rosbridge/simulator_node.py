"""The simulator as a peer in the graph: its channels and services. A channel is read only while somebody listens.

Readings are taken on the simulator's thread and handed over through a bounded queue; commands and calls go the other
way through LiveSimulator. The simulator's thread never waits for the graph's.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from uwsim.bridges.rosbridge.encoding import Growing, Sample
from uwsim.bridges.rosbridge.graph import LOGGER, Graph, Handler, Reply
from uwsim.channels import Channel, Service, keep_up
from uwsim.live import LiveSimulator, NotRunningError, Subscription

NAME = "/uwsim"
WAITING = 1000  # messages on their way from the simulator's thread; the oldest give way


class SimulatorNode:
    """Joins a live simulator's channels and services to a graph, on the graph's event loop."""

    def __init__(
        self,
        live: LiveSimulator,
        channels: Sequence[Channel],
        services: Iterable[Service],
        graph: Graph,
        loop: asyncio.AbstractEventLoop,
    ) -> None:
        self._live = live
        self._graph = graph
        self._loop = loop
        self._pool = ThreadPoolExecutor(4, thread_name_prefix="uwsim-service")
        self._vital = ThreadPoolExecutor(1, thread_name_prefix="uwsim-vital")
        self._channels = {channel.name: channel for channel in channels if channel.direction == "out"}
        self._subscriptions: dict[str, Subscription] = {}
        self._arrived: deque[tuple[str, Any]] = deque(maxlen=WAITING)
        self._drain_is_due = False
        self._is_closed = False
        self._going_on = keep_up(live, self._channels.values())
        graph.nodes[NAME] = None
        graph.on_demand.append(self._demand)
        self._abandoned = {c.name: c.abandoned for c in channels if c.abandoned is not None}
        graph.on_abandoned.append(self._abandon)
        for channel in channels:
            try:
                self._join(channel)
            except ValueError as error:  # a client has the topic already, as something else
                LOGGER.error("%s", error)
        for service in services:
            graph.advertise_service(NAME, service.name, service.type, self._server(service))

    def _join(self, channel: Channel) -> None:
        if channel.direction == "in":
            self._graph.subscribe(NAME, channel.name, channel.name, channel.type, self._applier(channel))
        elif self._graph.advertise(NAME, channel.name, channel.type, channel.latched).sinks:
            self._demand(channel.name, True)  # somebody has waited for it

    def close(self) -> None:
        """Read nothing more, and leave the graph."""
        self._is_closed = True
        for subscription in (*self._subscriptions.values(), *self._going_on):
            subscription.cancel()
        self._graph.on_demand.remove(self._demand)
        self._graph.on_abandoned.remove(self._abandon)
        self._graph.leave(NAME)
        for pool in (self._pool, self._vital):
            pool.shutdown(wait=False, cancel_futures=True)

    def _demand(self, name: str, wanted: bool) -> None:
        """Begin or end to read a channel."""
        channel = self._channels.get(name)
        if channel is None or self._is_closed:
            return
        if not wanted:
            subscription = self._subscriptions.pop(name, None)
            if subscription is not None:
                subscription.cancel()
            return
        try:
            if channel.rate_hz is None:
                self._live.read(channel.read).add_done_callback(lambda future: self._read_once(name, future))
            else:
                self._subscriptions[name] = self._live.every(
                    1.0 / channel.rate_hz, channel.read, lambda message: self._arrive(name, message)
                )
        except NotRunningError:
            LOGGER.warning("topic '%s': the simulator does not run", name)

    def _abandon(self, name: str) -> None:
        """Let a channel know that nobody commands by it any more."""
        abandoned = self._abandoned.get(name)
        if abandoned is not None:
            try:
                abandoned(self._live)
            except (NotRunningError, RuntimeError) as error:
                LOGGER.warning("topic '%s': %s", name, error)

    def _read_once(self, name: str, future: Future[Any]) -> None:
        if future.exception() is None:
            self._arrive(name, future.result())
        else:
            LOGGER.error("topic '%s': %s", name, future.exception())

    def _arrive(self, name: str, message: Any) -> None:
        """Take a reading, on the simulator's thread; None stands for none."""
        if message is None or self._is_closed:
            return
        self._arrived.append((name, message))
        if not self._drain_is_due:
            self._drain_is_due = True
            self._on_loop(self._drain)

    def _drain(self) -> None:
        self._drain_is_due = False
        if self._is_closed:
            return
        for _ in range(len(self._arrived)):
            name, message = self._arrived.popleft()
            topic, channel = self._graph.topics.get(name), self._channels[name]
            if topic is not None and (topic.sinks or channel.latched):
                time_ns = self._live.time_ns
                sample = Sample(message, time_ns) if channel.catch_up is None else Growing(channel.catch_up, time_ns)
                self._graph.publish(topic, sample, channel.latched)

    def _on_loop(self, function: Callable[..., None], *arguments: Any) -> None:
        try:
            self._loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:  # the loop has ended
            self._is_closed = True

    def _applier(self, channel: Channel) -> Callable[[Sample], None]:
        """Return what applies a client's message. ValueErrors go to the client whose message it is."""

        def apply(sample: Sample) -> None:
            try:
                channel.apply(self._live, sample.message)
            except NotRunningError as error:
                raise ValueError(f"topic '{channel.name}': {error}") from None

        return apply

    def _server(self, service: Service) -> Handler:
        """Return what serves calls on a thread of the pool: they may wait for steps."""

        def serve(arguments: Any, reply: Reply, caller: str) -> None:
            if not isinstance(arguments, dict):
                raise ValueError(f"service '{service.name}': args must be an object")
            pool = self._vital if service.is_vital else self._pool
            future = pool.submit(service.call, self._live, arguments)
            future.add_done_callback(lambda done: self._on_loop(_answer, done, reply))

        return serve


def _answer(done: Future[Any], reply: Reply) -> None:
    if done.cancelled():
        reply(False, "the server stops")
        return
    error = done.exception()
    if error is None:
        reply(True, done.result())
    else:
        if not isinstance(error, ValueError | RuntimeError):
            LOGGER.error("a service failed", exc_info=error)
        reply(False, str(error) or type(error).__name__)
