"""A ROS 2 node's connection over DDS: topics through Cyclone DDS, services through a small RTPS participant."""

from __future__ import annotations

from uwsim.bridges.ros2.dds import Events, Participant, RawReader, RawWriter
from uwsim.bridges.ros2.graph import (
    ENTITIES,
    ENTITIES_TOPIC,
    PARTICIPANT_DATA,
    dds_name,
    endpoint_data,
    entities_info,
)
from uwsim.bridges.ros2.qos import reader_qos, writer_qos
from uwsim.bridges.ros2.rtps_endpoints import RtpsServer
from uwsim.bridges.ros2.rtps_participant import RtpsParticipant
from uwsim.bridges.ros2.settings import Ros2Settings
from uwsim.bridges.ros2.transport import DEPTH
from uwsim.channels.ros.cdr import encode


class DdsTransport:
    """A `Transport`. node: the node's name. Raises ValueError or OSError."""

    def __init__(self, settings: Ros2Settings, node: str) -> None:
        self._settings, self._node = settings, node
        self._participant = Participant(settings, PARTICIPANT_DATA)
        self._readers: list[RawReader] = []
        self._writers: list[RawWriter] = []
        self._events = self._participant.wait_set()
        self._services: RtpsParticipant | None = None

    def writer(self, topic: str, type_name: str, depth: int, *, latched: bool) -> RawWriter:
        """Return a new writer."""
        return self._writer(dds_name(topic), type_name, depth, latched=latched)

    def reader(self, topic: str, type_name: str, *, reliable: bool) -> RawReader:
        """Return a new reader."""
        return self._reader(dds_name(topic), type_name, reliable=reliable)

    def server(self, name: str, type_name: str) -> RtpsServer:
        """Return a new server of a service."""
        self._services = self._services or RtpsParticipant(self._settings)
        return self._services.server(name, type_name, self._events.put)

    def wait_set(self) -> Events:
        """Return an object that waits for events from all readers, writers and servers."""
        return self._events

    def announce(self) -> None:
        """Publish the node's endpoint list, which DDS also sends to participants that join later."""
        distro = self._settings.distro
        readers, writers = ([one.guid for one in ends] for ends in (self._readers, self._writers))
        if self._services is not None:
            self._services.start()
            more = self._services.guids()
            readers, writers = readers + more[0], writers + more[1]
        info = entities_info(distro, self._participant.guid, self._node, readers, writers)
        self._graph = self._writer(ENTITIES_TOPIC, ENTITIES, 1, latched=True)
        self._graph.write(encode(info, distro))

    def close(self) -> None:
        """Leave the domain; other participants are notified."""
        if self._services is not None:
            self._services.close()
        self._participant.close()

    def _reader(self, name: str, type_name: str, *, reliable: bool) -> RawReader:
        qos = reader_qos(DEPTH, reliable=reliable, user_data=endpoint_data(type_name, self._settings.distro))
        self._readers.append(self._participant.reader(name, type_name, qos))
        return self._readers[-1]

    def _writer(self, name: str, type_name: str, depth: int, *, latched: bool = False) -> RawWriter:
        qos = writer_qos(depth, latched=latched, user_data=endpoint_data(type_name, self._settings.distro))
        self._writers.append(self._participant.writer(name, type_name, qos))
        return self._writers[-1]
