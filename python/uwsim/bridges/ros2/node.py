"""Ros2Node: a live simulator as a node of ROS 2, without ROS."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self

from uwsim.bridges.ros2.dds import Participant, RawReader, RawWriter
from uwsim.bridges.ros2.graph import (
    ENTITIES,
    ENTITIES_TOPIC,
    PARTICIPANT_DATA,
    dds_name,
    endpoint_data,
    entities_info,
)
from uwsim.bridges.ros2.parameter_topic import parameter_channel
from uwsim.bridges.ros2.qos import DEPTH, reader_qos, writer_qos
from uwsim.bridges.ros2.rosout import LOG, LOG_DEPTH, LOG_TOPIC, WARN, log_message
from uwsim.bridges.ros2.service_topics import ServiceTopics
from uwsim.bridges.ros2.settings import Ros2Settings
from uwsim.channels import Channel, Service, keep_up, require_live
from uwsim.channels.cdr import encode, is_as_in_jazzy
from uwsim.channels.feed import Feed, Reading, Readings
from uwsim.channels.messages import from_bytes
from uwsim.channels.outgoing import Line, Outgoing, queue_of
from uwsim.live import LiveSimulator, NotRunningError

NAME = "uwsim"
LOOK_S = 0.5  # between two looks at whether to end, if nothing happens
PAUSE_S = 0.001  # between two takes: so nobody's flood takes the whole processor
COMMAND_BYTES_MAX = 1 << 20

logger = logging.getLogger("uwsim.ros2")


class Ros2Node:
    """The node /uwsim, whose topics are the channels of a live simulator, and topics in place of its services.

        with LiveSimulator("lake") as live, Ros2Node(live, channels(live.simulator), services(live.simulator)):
            ...

    A channel is read while somebody subscribes to it. Messages are encoded and written on a thread, commands are
    received on another. feed: shared with other sinks, so that a reading is taken and encoded once. live: None with the
    feed of a recording, to which nobody can say anything. Raises ValueError for settings and names that ROS 2 does not
    allow, OSError if the domain cannot be joined.
    """

    def __init__(
        self,
        live: LiveSimulator | None,
        channels: Sequence[Channel],
        services: Sequence[Service] = (),
        settings: Ros2Settings | None = None,
        *,
        feed: Readings | None = None,
    ) -> None:
        self.settings = settings or Ros2Settings()
        self._calls = ServiceTopics(services, self._say)
        self._reliable = [] if live is None else [*self._calls.channels, parameter_channel(self._say)]
        self.channels = [*channels, *self._reliable]
        self._live = live
        self._feed = feed or Feed(require_live(live))
        self._lines: dict[RawWriter, tuple[Channel, Line]] = {}
        self._inputs: dict[RawReader, Channel] = {}
        self._ends: dict[RawWriter, Callable[[], None]] = {}
        self._stopping = threading.Event()
        for channel in self.channels:
            dds_name(channel.name)
        self._participant = Participant(self.settings, PARTICIPANT_DATA)
        self._outgoing = Outgoing("uwsim-ros2-write")
        self._events = self._participant.wait_set()
        self._log = self._writer(LOG_TOPIC, LOG, LOG_DEPTH, latched=True)
        self._log_line = Line(LOG_TOPIC, LOG_DEPTH)
        for channel in self.channels:
            self._join(channel)
        self._going_on = keep_up(live, self.channels)
        self._tell_graph()
        self._thread = threading.Thread(target=self._listen, name="uwsim-ros2-read", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> dict[str, int]:
        """How many messages of each topic gave way to newer ones, since the network did not take them in time."""
        return {channel.name: line.dropped for channel, line in self._lines.values() if line.dropped}

    @property
    def written(self) -> dict[str, int]:
        """How many messages of each topic were written."""
        return {channel.name: line.written for channel, line in self._lines.values() if line.written}

    def close(self) -> None:
        """Leave ROS 2: other nodes are told, and both threads end."""
        if self._stopping.is_set():
            return
        self._stopping.set()
        for end in self._ends.values():
            end()
        for subscription in self._going_on:
            subscription.cancel()
        self._calls.close()
        self._events.wake()
        self._thread.join(5.0)
        self._outgoing.close()
        self._participant.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _join(self, channel: Channel) -> None:
        if channel.direction == "out":
            writer = self._writer(channel.name, channel.type, 1 if channel.latched else DEPTH, channel.latched)
            self._lines[writer] = channel, Line(channel.name, queue_of(channel.type))
            self._events.attach(writer)
        else:
            qos = reader_qos(DEPTH, reliable=channel in self._reliable, user_data=self._data(channel.type))
            reader = self._participant.reader(dds_name(channel.name), channel.type, qos)
            self._inputs[reader] = channel
            self._events.attach(reader)

    def _writer(self, name: str, type_name: str, depth: int, latched: bool) -> RawWriter:
        qos = writer_qos(depth, latched=latched, user_data=self._data(type_name))
        return self._participant.writer(dds_name(name), type_name, qos)

    def _data(self, type_name: str) -> bytes:
        return endpoint_data(type_name, self.settings.distro)

    def _tell_graph(self) -> None:
        """Publish which endpoints are the node's. DDS hands it to whoever comes later."""
        distro = self.settings.distro
        qos = writer_qos(1, latched=True, user_data=self._data(ENTITIES))
        self._graph = self._participant.writer(ENTITIES_TOPIC, ENTITIES, qos)
        readers = [reader.guid for reader in self._inputs]
        writers = [self._log.guid, *(writer.guid for writer in self._lines)]
        info = entities_info(distro, self._participant.guid, NAME, readers, writers)
        self._graph.write(encode(info, distro))

    def _listen(self) -> None:
        """Receive commands, and notice who begins or ends to subscribe."""
        while not self._stopping.is_set():
            for source in self._events.wait(LOOK_S):
                if isinstance(source, RawWriter):
                    self._demand(source)
                else:
                    self._receive(source)
            self._stopping.wait(PAUSE_S)

    def _demand(self, writer: RawWriter) -> None:
        """Begin or end to read a channel. What builds on earlier messages is said anew to whoever comes later."""
        channel, _ = self._lines[writer]
        count = writer.readers()
        if count and writer not in self._ends:
            try:
                self._ends[writer] = self._feed.listen(channel, lambda reading: self._send(writer, reading))
            except NotRunningError:
                logger.warning("topic '%s': the simulator does not run", channel.name)
        elif count and channel.catch_up is not None:
            newest = self._feed.newest(channel)
            if newest is not None:
                self._send(writer, newest)
        elif not count and writer in self._ends:
            self._ends.pop(writer)()

    def _send(self, writer: RawWriter, reading: Reading) -> None:
        """Queue a reading, on the simulator's thread."""
        channel, line = self._lines[writer]
        distro = self.settings.distro
        if is_as_in_jazzy(channel.type, distro):
            self._outgoing.offer(line, lambda: writer.write(reading.cdr))
        else:
            self._outgoing.offer(line, lambda: writer.write(encode(reading.message, distro)))

    def _receive(self, reader: RawReader) -> None:
        channel = self._inputs[reader]
        for data in reader.take(DEPTH):
            try:
                if len(data) > COMMAND_BYTES_MAX:
                    raise ValueError(f"{len(data)} bytes: must be {COMMAND_BYTES_MAX} at most")
                channel.apply(require_live(self._live), from_bytes(data, channel.type))
            except (ValueError, RuntimeError) as error:
                self._say(WARN, f"/{channel.name}: {error}")
            except Exception:
                logger.exception("topic '%s': a message could not be applied", channel.name)

    def _say(self, level: int, text: str) -> None:
        """Say something on /rosout and in our own log."""
        logger.log(logging.WARNING if level >= WARN else logging.INFO, "%s", text)
        message: Any = log_message(require_live(self._live).simulator.time_ns, NAME, level, text)
        self._outgoing.offer(self._log_line, lambda: self._log.write(encode(message, self.settings.distro)))
