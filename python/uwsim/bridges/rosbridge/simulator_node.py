"""The simulator as a peer in the graph, with its channels and services. Channels are read only while subscribed to.

Readings arrive from the feed on the simulator's thread, and are forwarded through bounded queues. Commands and calls go
in the opposite direction. The simulator's thread never waits for the graph's thread.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from uwsim.bridges.actions import Offered
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.doors.listener import post
from uwsim.bridges.rosbridge.encoding import Growing, Sample
from uwsim.bridges.rosbridge.graph import Graph, Reply
from uwsim.bridges.rosbridge.own_actions import OwnAction
from uwsim.channels import Channel, Service, require_live
from uwsim.channels.calls.command_services import named_arguments
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import Line, Turns, queue_of
from uwsim.live import LiveSimulator, NotRunningError

LIVE, PLAYED = "/uwsim", "/playback"
"""The node's name in the graph for a live simulator, and for a recording."""
WAITING = 10  # multiple of a topic's usual queue, since one client may keep the network thread busy that long


class SimulatorNode(Bridge):
    """Connects a live simulator's channels, services and actions, or a recording's channels, to a graph."""

    peer = "a rosbridge client"

    def __init__(
        self,
        live: LiveSimulator | None,
        channels: Iterable[Channel],
        services: Iterable[Service],
        feed: Readings | None,
        graph: Graph,
        loop: asyncio.AbstractEventLoop,
        actions: Sequence[Offered] = (),
    ) -> None:
        super().__init__("rosbridge", live, channels, services, feed)
        self._name = PLAYED if live is None else LIVE
        self._graph = graph
        self._loop = loop
        self._arrived: Turns[tuple[Reading, Sample]] = Turns()
        self._lines: dict[str, Line[tuple[Reading, Sample]]] = {
            name: Line(name, WAITING * queue_of(channel.type), channel.drops) for name, channel in self.outputs.items()
        }
        self._latched: dict[str, Reading] = {}  # the latest message on each latched channel
        self._drain_is_due = False
        graph.nodes[self._name] = None
        graph.on_demand.append(self._notice_demand)
        graph.on_joined.append(self._notice_joined)
        graph.on_abandoned.append(self._notice_abandoned)
        for channel in channels:
            try:
                self._join(channel)
            except ValueError as error:  # a client already uses the topic with a different type
                self.log.error("%s", error)
        for service in self.services.values():
            graph.advertise_service(self._name, service.name, service.type, partial(self._serve, service))
        self._actions: list[OwnAction] = []
        for action in actions:
            handler = OwnAction(require_live(live), action, partial(post, loop))
            self._actions.append(handler)
            graph.advertise_action(self._name, action.name, action.type, handler)
        self.start_updates()

    def close(self) -> bool:
        """Stop reading and leave the graph."""
        was_open = super().close()
        if was_open:
            for action in self._actions:
                action.close()
            self._graph.on_demand.remove(self._notice_demand)
            self._graph.on_joined.remove(self._notice_joined)
            self._graph.on_abandoned.remove(self._notice_abandoned)
            self._graph.leave(self._name)
        return was_open

    def _join(self, channel: Channel) -> None:
        if channel.direction == "in":
            self._graph.subscribe(self._name, channel.name, channel.name, channel.type, partial(self._apply, channel))
        elif self._graph.advertise(self._name, channel.name, channel.type, channel.delivery.latched).sinks:
            self.demand(channel.name, True)  # a client already subscribes to it

    def _notice_demand(self, name: str, is_wanted: bool) -> None:
        if name in self.outputs:
            self.demand(name, is_wanted)

    def _notice_joined(self, name: str) -> None:
        """Read a channel once for a further subscriber while time stands still; otherwise the next reading comes."""
        if name not in self.outputs or self.live is None or not self.live.paused or not self.is_read(name):
            return
        try:
            self.feed.listen(self.outputs[name], self.take)()
        except NotRunningError:
            self.log.debug("topic '%s': the simulator does not run", name)

    def _notice_abandoned(self, name: str) -> None:
        if name in self.inputs:
            self.abandon(self.inputs[name])

    def take(self, reading: Reading) -> None:
        """Queue a reading on the simulator's thread."""
        catch_up = reading.channel.delivery.catch_up
        sample = Sample(reading.message, reading.time_ns) if catch_up is None else Growing(catch_up, reading.time_ns)
        self._arrived.put(self._lines[reading.channel.name], (reading, sample))
        if not self._drain_is_due:
            self._drain_is_due = True
            post(self._loop, self._drain)

    def _drain(self) -> None:
        self._drain_is_due = False
        for _ in range(len(self._arrived)):
            turn = self._arrived.take(wait=False)
            assert turn is not None  # no other thread takes
            reading, sample = turn[1]
            name, latch = reading.channel.name, reading.channel.delivery.latched
            topic = self._graph.topics.get(name)
            if self.is_closed or topic is None or not (topic.sinks or latch):
                continue
            if latch and self._latched.get(name) is reading:
                continue  # subscribers already received it from the graph
            if latch:
                self._latched[name] = reading
            self._graph.publish(topic, sample, latch)

    def _apply(self, channel: Channel, sample: Sample) -> None:
        """Apply a client's message. A ValueError is reported to the client that sent it."""
        try:
            self.apply(channel, sample.message)
        except NotRunningError as error:
            raise ValueError(f"topic '{channel.name}': {error}") from None

    def _serve(self, service: Service, arguments: Any, reply: Reply, caller: str) -> None:
        if isinstance(arguments, list):
            arguments = named_arguments(service, arguments)
        if not isinstance(arguments, dict):
            raise ValueError(f"service '{service.name}': args must be an object or a list")
        self.call(service, arguments, partial(post, self._loop, reply))
