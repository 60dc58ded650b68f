"""Ros2Node: a live simulator as a ROS 2 node, without ROS."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from uwsim.bridges.actions import Offered
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.ros2.action_server import ActionServer
from uwsim.bridges.ros2.graph import dds_name
from uwsim.bridges.ros2.lossy_readers import LossyReaders
from uwsim.bridges.ros2.parameters import EVENTS, EVENTS_DEPTH, EVENTS_TOPIC, ParameterEvents, parameter_channel
from uwsim.bridges.ros2.rosout import LOG, LOG_DEPTH, LOG_TOPIC, WARN, log_message
from uwsim.bridges.ros2.service_topics import service_channels
from uwsim.bridges.ros2.settings import Ros2Settings, need_middleware
from uwsim.bridges.ros2.transport import DEPTH, Call, Reader, Server, Transport, Writer
from uwsim.channels import Channel, Service, require_live
from uwsim.channels.calls.rcl_parameters import rcl_parameter_services
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import Job, Line, Outgoing, queue_of
from uwsim.channels.names import channels_in, node_name
from uwsim.channels.ros.action_types import ONLY_IN_JAZZY, load_action_types
from uwsim.channels.ros.cdr import encode, is_as_in_jazzy
from uwsim.channels.ros.messages import from_bytes
from uwsim.channels.ros.service_messages import request_values, response_message
from uwsim.channels.ros.service_types import SERVICE_TYPES, load_service_types, request_type
from uwsim.live import LiveSimulator

LOOK_S = 0.5  # interval at which idle threads check whether to stop
PAUSE_S = 0.001  # pause between reads, so that a flood of messages cannot use up the processor
OPEN_CALLS_MAX = 100


def transport_of(settings: Ros2Settings, node: str) -> Transport:
    """Return a new connection through the middleware chosen in the settings. Raises ValueError or OSError."""
    need_middleware(settings.rmw)
    if settings.rmw == "zenoh":
        from uwsim.bridges.ros2.zenoh_transport import ZenohTransport

        return ZenohTransport(settings, node)
    from uwsim.bridges.ros2.dds_transport import DdsTransport

    return DdsTransport(settings, node)


class Ros2Node(Bridge):
    """The node /uwsim: a live simulator's channels as topics, its services, and topics that call these services.

        with LiveSimulator("lake") as live:
            table = Table(live.simulator)
            with Ros2Node(live, table.channels, table.services):
                ...

    A channel is read only while a node subscribes to it. Messages are encoded and written on one thread; commands are
    received on another. live: None if the feed plays a recording, which accepts no commands. feed: shared with other
    sinks so that each reading is taken and encoded only once. namespace: part of the node's name. actions: flights that
    peers may start; see `uwsim.bridges.actions.actions_of`. Raises ValueError for settings or names that ROS 2 does not
    allow, and OSError if the domain cannot be joined.
    """

    peer = "a ROS 2 node"

    def __init__(
        self,
        live: LiveSimulator | None,
        channels: Sequence[Channel],
        services: Sequence[Service] = (),
        settings: Ros2Settings | None = None,
        *,
        feed: Readings | None = None,
        namespace: str = "",
        actions: Sequence[Offered] = (),
    ) -> None:
        self.name = node_name(namespace)
        self.settings = settings or Ros2Settings()
        self._reliable: list[Channel] = []
        if live is not None:
            load_service_types(self.settings.distro)
            self._reliable = service_channels(services, self.call, self._report)
            self._reliable += channels_in(namespace, [parameter_channel(self._report)])
        self.channels = [*channels, *self._reliable]
        for channel in self.channels:
            dds_name(channel.name)
        super().__init__("ros2", live, self.channels, services, feed, open_calls=OPEN_CALLS_MAX)
        self._writers: dict[str, Writer] = {}
        self._lines: dict[str, Line[Job]] = {}
        self._sources: dict[Writer | Reader | Server, Channel] = {}
        self._calls: dict[Writer | Reader | Server, Callable[[Call], None]] = {}
        self._actions: list[ActionServer] = []
        self._lossy = LossyReaders(partial(self._report, WARN))
        self._stopping = threading.Event()
        self._transport = transport_of(self.settings, self.name)
        self._outgoing = Outgoing("uwsim-ros2-write")
        self._events = self._transport.wait_set()
        self._log = self._transport.writer(LOG_TOPIC, LOG, LOG_DEPTH, latched=True)
        self._log_line: Line[Job] = Line(LOG_TOPIC, LOG_DEPTH)
        for channel in self.channels:
            self._join(channel)
        self._parameter_events: ParameterEvents | None = None
        if live is not None:
            self._serve(live, services)
            self._act(live, actions)
        self.start_updates()
        self._transport.announce()
        self._thread = threading.Thread(target=self._listen, name="uwsim-ros2-read", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> dict[str, int]:
        """The number of messages dropped on each topic in favour of newer ones because the network was too slow."""
        return {name: line.drops.count for name, line in self._lines.items() if line.drops.count}

    @property
    def written(self) -> dict[str, int]:
        """The number of messages written to each topic."""
        return {name: line.written for name, line in self._lines.items() if line.written}

    def close(self) -> bool:
        """Leave the domain; other nodes are notified, and both threads end."""
        was_open = super().close()
        if was_open:
            for server in self._actions:
                server.close()
            self._stopping.set()
            self._events.wake()
            self._thread.join(5.0)
            if self._parameter_events is not None:
                self._parameter_events.close()
            self._outgoing.close()
            self._transport.close()
        return was_open

    def _join(self, channel: Channel) -> None:
        source: Writer | Reader
        if channel.direction == "out":
            depth = 1 if channel.delivery.latched else DEPTH
            source = self._transport.writer(channel.name, channel.type, depth, latched=channel.delivery.latched)
            self._writers[channel.name] = source
            self._lines[channel.name] = Line(channel.name, queue_of(channel.type), channel.drops)
        else:
            source = self._transport.reader(channel.name, channel.type, reliable=channel in self._reliable)
        self._sources[source] = channel
        self._events.attach(source)

    def _serve(self, live: LiveSimulator, services: Sequence[Service]) -> None:
        """Offer the services whose types are defined, and the parameters."""
        for service in (*services, *rcl_parameter_services(self.name)):
            if service.type in SERVICE_TYPES:
                self._offer(service.name, service.type, partial(self._call_service, service))
            else:
                self._report(WARN, f"/{service.name}: only by a topic: its type {service.type} is not defined")
        publish = self._publisher(EVENTS_TOPIC, EVENTS, EVENTS_DEPTH, latched=False)
        self._parameter_events = ParameterEvents(live, f"/{self.name}", publish)

    def _act(self, live: LiveSimulator, actions: Sequence[Offered]) -> None:
        """Offer the actions whose types exist in the distribution."""
        if actions:
            load_action_types(self.settings.distro)
        for action in actions:
            if self.settings.distro == "jazzy" or action.type not in ONLY_IN_JAZZY:
                warn = partial(self._report, WARN)
                server = ActionServer(live, action, self.settings.distro, self._publisher, self._offer, warn)
                self._actions.append(server)

    def _offer(self, name: str, type_name: str, take: Callable[[Call], None]) -> None:
        """Offer a service; `take` receives its calls on the reading thread."""
        server = self._transport.server(name, type_name)
        self._calls[server] = take
        self._events.attach(server)

    def _publisher(self, topic: str, type_name: str, depth: int, *, latched: bool) -> Callable[[Any], None]:
        """Return a function that publishes messages on a new topic."""
        writer = self._transport.writer(topic, type_name, depth, latched=latched)
        line: Line[Job] = Line(topic, max(depth, DEPTH))
        return lambda message: self._outgoing.offer(line, lambda: writer.write(encode(message, self.settings.distro)))

    def _listen(self) -> None:
        """Receive commands and calls, and track when subscribers and publishers come and go."""
        while not self._stopping.is_set():
            for source in self._events.wait(LOOK_S):
                channel = self._sources.get(source)
                if channel is None:
                    self._take_calls(source)
                elif channel.direction == "out":
                    self._notice_readers(channel, source)  # type: ignore[arg-type]
                else:
                    for data in source.take(DEPTH):  # type: ignore[union-attr]
                        self.receive(channel, data, from_bytes)  # type: ignore[arg-type]
                    if not source.writers():  # type: ignore[union-attr]
                        self.abandon(channel)
            self._stopping.wait(PAUSE_S)

    def _take_calls(self, server: Writer | Reader | Server) -> None:
        """Process the calls that have arrived at a server; sources of other kinds have none."""
        take = self._calls.get(server)
        for call in server.take(DEPTH) if take is not None else ():  # type: ignore[union-attr]
            try:
                take(call)  # type: ignore[misc, arg-type]
            except Exception:
                self.log.exception("a call could not be made")

    def _call_service(self, service: Service, call: Call) -> None:
        try:
            request = request_values(service.type, from_bytes(call.request, request_type(service.type)))
            self.call(service, request, partial(self._respond, service, call))
        except (ValueError, RuntimeError) as error:
            self._respond(service, call, False, str(error))

    def _respond(self, service: Service, call: Call, succeeded: bool, values: Any) -> None:
        try:
            call.reply(encode(response_message(service.type, succeeded, values), self.settings.distro))
        except Exception:  # on a thread whose futures nobody awaits
            self.log.exception("service '%s': the response could not be sent", service.name)

    def _notice_readers(self, channel: Channel, writer: Writer) -> None:
        """Start or stop reading a channel. If its messages build on each other, late readers receive all messages."""
        count = writer.readers()
        self._lossy.note(channel.name, count > 0 and writer.has_best_effort_readers())
        was_read = self.is_read(channel.name)
        self.demand(channel.name, count > 0)
        if count and was_read and channel.delivery.catch_up is not None:
            newest = self.feed.newest(channel)
            if newest is not None:
                self.take(newest)

    def take(self, reading: Reading) -> None:
        """Queue a reading on the simulator's thread."""
        name, distro = reading.channel.name, self.settings.distro
        if is_as_in_jazzy(reading.channel.type, distro):
            self._outgoing.offer(self._lines[name], lambda: self._write(name, reading.cdr))
        else:
            self._outgoing.offer(self._lines[name], lambda: self._write(name, encode(reading.message, distro)))

    def _write(self, name: str, cdr: memoryview) -> bool:
        self._lossy.check(name, len(cdr))
        return self._writers[name].write(cdr)

    def refuse(self, reason: str) -> None:
        """Report a rejected command on /rosout."""
        self._report(WARN, reason)

    def _report(self, level: int, text: str) -> None:
        """Report a message on /rosout and in our own log."""
        self.log.log(logging.WARNING if level >= WARN else logging.INFO, "%s", text)
        message: Any = log_message(require_live(self.live).simulator.time_ns, self.name, level, text)
        self._outgoing.offer(self._log_line, lambda: self._log.write(encode(message, self.settings.distro)))
