"""Ros2Node: a live simulator as a ROS 2 node, without ROS."""

from __future__ import annotations

import logging
import threading
from collections.abc import Sequence
from typing import Any

from uwsim.bridges.bridge import Bridge
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
from uwsim.bridges.ros2.service_topics import service_channels
from uwsim.bridges.ros2.settings import Ros2Settings
from uwsim.channels import Channel, Service, require_live
from uwsim.channels.cdr import encode, is_as_in_jazzy
from uwsim.channels.feed import Reading, Readings
from uwsim.channels.messages import from_bytes
from uwsim.channels.names import channels_in, node_name
from uwsim.channels.outgoing import Job, Line, Outgoing, queue_of
from uwsim.live import LiveSimulator

LOOK_S = 0.5  # interval at which idle threads check whether to stop
PAUSE_S = 0.001  # pause between reads, so that a flood of messages cannot use up the processor
OPEN_CALLS_MAX = 100


class Ros2Node(Bridge):
    """The node /uwsim, whose topics are a live simulator's channels; additional topics replace its services.

        with LiveSimulator("lake") as live:
            table = Table(live.simulator)
            with Ros2Node(live, table.channels, table.services):
                ...

    A channel is read only while a node subscribes to it. Messages are encoded and written on one thread; commands are
    received on another. live: None if the feed plays a recording, which accepts no commands. feed: shared with other
    sinks so that each reading is taken and encoded only once. namespace: part of the node's name. Raises
    ValueError for settings or names that ROS 2 does
    not allow, and OSError if the domain cannot be joined.
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
    ) -> None:
        self.name = node_name(namespace)
        self.settings = settings or Ros2Settings()
        self._reliable: list[Channel] = []
        if live is not None:
            self._reliable = service_channels(services, self.call, self._say)
            self._reliable += channels_in(namespace, [parameter_channel(self._say)])
        self.channels = [*channels, *self._reliable]
        for channel in self.channels:
            dds_name(channel.name)
        super().__init__("ros2", live, self.channels, services, feed, open_calls=OPEN_CALLS_MAX)
        self._writers: dict[str, RawWriter] = {}
        self._lines: dict[str, Line[Job]] = {}
        self._sources: dict[RawWriter | RawReader, Channel] = {}
        self._stopping = threading.Event()
        self._participant = Participant(self.settings, PARTICIPANT_DATA)
        self._outgoing = Outgoing("uwsim-ros2-write")
        self._events = self._participant.wait_set()
        self._log = self._writer(LOG_TOPIC, LOG, LOG_DEPTH, latched=True)
        self._log_line: Line[Job] = Line(LOG_TOPIC, LOG_DEPTH)
        for channel in self.channels:
            self._join(channel)
        self.keep_up()
        self._tell_graph()
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
            self._stopping.set()
            self._events.wake()
            self._thread.join(5.0)
            self._outgoing.close()
            self._participant.close()
        return was_open

    def _join(self, channel: Channel) -> None:
        source: RawWriter | RawReader
        if channel.direction == "out":
            source = self._writer(channel.name, channel.type, 1 if channel.latched else DEPTH, channel.latched)
            self._writers[channel.name] = source
            self._lines[channel.name] = Line(channel.name, queue_of(channel.type), channel.drops)
        else:
            qos = reader_qos(DEPTH, reliable=channel in self._reliable, user_data=self._data(channel.type))
            source = self._participant.reader(dds_name(channel.name), channel.type, qos)
        self._sources[source] = channel
        self._events.attach(source)

    def _writer(self, name: str, type_name: str, depth: int, latched: bool) -> RawWriter:
        qos = writer_qos(depth, latched=latched, user_data=self._data(type_name))
        return self._participant.writer(dds_name(name), type_name, qos)

    def _data(self, type_name: str) -> bytes:
        return endpoint_data(type_name, self.settings.distro)

    def _tell_graph(self) -> None:
        """Publish the node's endpoint list, which DDS also sends to participants that join later."""
        distro = self.settings.distro
        qos = writer_qos(1, latched=True, user_data=self._data(ENTITIES))
        self._graph = self._participant.writer(ENTITIES_TOPIC, ENTITIES, qos)
        readers = [source.guid for source in self._sources if isinstance(source, RawReader)]
        writers = [self._log.guid, *(writer.guid for writer in self._writers.values())]
        info = entities_info(distro, self._participant.guid, self.name, readers, writers)
        self._graph.write(encode(info, distro))

    def _listen(self) -> None:
        """Receive commands, and track when subscribers and publishers come and go."""
        while not self._stopping.is_set():
            for source in self._events.wait(LOOK_S):
                if isinstance(source, RawWriter):
                    self._notice_readers(self._sources[source], source.readers())
                else:
                    for data in source.take(DEPTH):
                        self.receive(self._sources[source], data, from_bytes)
                    if not source.writers():
                        self.abandon(self._sources[source])
            self._stopping.wait(PAUSE_S)

    def _notice_readers(self, channel: Channel, count: int) -> None:
        """Start or stop reading a channel. If its messages build on each other, late readers receive all of them."""
        was_read = self.is_read(channel.name)
        self.demand(channel.name, count > 0)
        if count and was_read and channel.catch_up is not None:
            newest = self.feed.newest(channel)
            if newest is not None:
                self.take(newest)

    def take(self, reading: Reading) -> None:
        """Queue a reading on the simulator's thread."""
        name, distro = reading.channel.name, self.settings.distro
        writer = self._writers[name]
        if is_as_in_jazzy(reading.channel.type, distro):
            self._outgoing.offer(self._lines[name], lambda: writer.write(reading.cdr))
        else:
            self._outgoing.offer(self._lines[name], lambda: writer.write(encode(reading.message, distro)))

    def refuse(self, reason: str) -> None:
        """Report a rejected command on /rosout."""
        self._say(WARN, reason)

    def _say(self, level: int, text: str) -> None:
        """Report a message on /rosout and in our own log."""
        self.log.log(logging.WARNING if level >= WARN else logging.INFO, "%s", text)
        message: Any = log_message(require_live(self.live).simulator.time_ns, self.name, level, text)
        self._outgoing.offer(self._log_line, lambda: self._log.write(encode(message, self.settings.distro)))
