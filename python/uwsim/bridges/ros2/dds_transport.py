"""A ROS 2 node's connection by DDS: topics for all peers, and services as rmw_cyclonedds has them."""

from __future__ import annotations

import struct
import time
from collections.abc import Sequence
from functools import partial
from typing import Any

from cyclonedds.qos import Policy

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
from uwsim.bridges.ros2.settings import Ros2Settings
from uwsim.bridges.ros2.transport import DEPTH, Call
from uwsim.channels import Service
from uwsim.channels.cdr import encode
from uwsim.channels.service_types import request_type, response_type

CYCLONE_DDS = b"\x01\x10"
"""The vendor at the beginning of a GUID (RTPS 2.5, section 9.3.1.5)."""
CDR_HEADER, REQUEST_HEADER = 4, 16
REPLIES = 100  # responses that a slow client may lag behind
READER_S, LOOK_S = 0.1, 0.005


class DdsTransport:
    """A `Transport`. node: the node's name. Raises ValueError or OSError."""

    def __init__(self, settings: Ros2Settings, node: str) -> None:
        self._settings, self._node = settings, node
        self._participant = Participant(settings, PARTICIPANT_DATA)
        self._readers: list[RawReader] = []
        self._writers: list[RawWriter] = []
        self._strangers: set[bytes] = set()

    def writer(self, topic: str, type_name: str, depth: int, *, latched: bool) -> RawWriter:
        """Return a new writer."""
        return self._writer(dds_name(topic), type_name, depth, latched=latched)

    def reader(self, topic: str, type_name: str, *, reliable: bool) -> RawReader:
        """Return a new reader."""
        return self._reader(dds_name(topic), type_name, reliable=reliable)

    def server(self, service: Service) -> DdsServer:
        """Return a new server."""
        name = dds_name(service.name).removeprefix("rt/")
        identity = f"serviceid={'.'.join(f'{byte:x}' for byte in self._participant.guid)}.{len(self._readers):x};"
        requests = self._reader(f"rq/{name}Request", request_type(service.type), reliable=True, more=identity.encode())
        replies = self._writer(f"rr/{name}Reply", response_type(service.type), REPLIES, more=identity.encode())
        return DdsServer(service, requests, replies, self._strangers)

    def wait_set(self) -> Events:
        """Return an object that waits on all of them."""
        return self._participant.wait_set()

    def announce(self) -> None:
        """Publish the node's endpoint list, which DDS also sends to participants that join later."""
        distro = self._settings.distro
        readers, writers = ([one.guid for one in ends] for ends in (self._readers, self._writers))
        info = entities_info(distro, self._participant.guid, self._node, readers, writers)
        self._graph = self._writer(ENTITIES_TOPIC, ENTITIES, 1, latched=True)
        self._graph.write(encode(info, distro))

    def close(self) -> None:
        """Leave the domain; other participants are notified."""
        self._participant.close()

    def _reader(self, name: str, type_name: str, *, reliable: bool, more: bytes = b"") -> RawReader:
        qos = reader_qos(DEPTH, reliable=reliable, user_data=more + endpoint_data(type_name, self._settings.distro))
        self._readers.append(self._participant.reader(name, type_name, qos))
        return self._readers[-1]

    def _writer(self, name: str, type_name: str, depth: int, *, latched: bool = False, more: bytes = b"") -> RawWriter:
        qos = writer_qos(depth, latched=latched, user_data=more + endpoint_data(type_name, self._settings.distro))
        self._writers.append(self._participant.writer(name, type_name, qos))
        return self._writers[-1]


class DdsServer:
    """A `Server` for peers with rmw_cyclonedds, which put a call's identity, client and sequence, before the message.

    Other middlewares put it into an inline QoS (related_sample_identity), which our DDS library neither reads nor
    writes. strangers: the participants found so far that use one.
    """

    def __init__(self, service: Service, requests: RawReader, replies: RawWriter, strangers: set[bytes]) -> None:
        self.service = service
        self.entities = requests.entities
        self._requests, self._replies, self._strangers = requests, replies, strangers

    def take(self, limit: int) -> list[Call]:
        """Return up to `limit` calls that have arrived."""
        return [self._call(data, self._requests.writer_of(handle)) for data, handle in self._requests.take_from(limit)]

    def strangers(self) -> int:
        """Return the number of participants newly found that use another middleware."""
        self._requests.writers()
        before = len(self._strangers)
        for client in self._requests.matched():
            if not is_cyclone(client):
                self._strangers.add(client.participant_key.bytes)
        return len(self._strangers) - before

    def _call(self, data: bytes, client: Any) -> Call:
        order = "<" if data[1] & 1 else ">"
        start = CDR_HEADER + REQUEST_HEADER
        identity = struct.pack("<Qq", *struct.unpack(f"{order}Qq", data[CDR_HEADER:start]))
        return Call(data[:CDR_HEADER] + data[start:], partial(self._reply, identity, client))

    def _reply(self, identity: bytes, client: Any, response: memoryview) -> bool:
        """Write a response once the client's reader is known, as rmw_cyclonedds does."""
        deadline = time.monotonic() + READER_S
        while not self._is_heard_by(client) and time.monotonic() < deadline:
            time.sleep(LOOK_S)
        return self._replies.write(memoryview(bytes(response[:CDR_HEADER]) + identity + response[CDR_HEADER:]))

    def _is_heard_by(self, client: Any) -> bool:
        """Return whether the reader of a client is matched; its writer and its reader carry the same clientid."""
        wanted = _client_id(client)
        return not wanted or any(_client_id(reader) == wanted for reader in self._replies.matched())


def is_cyclone(endpoint: Any) -> bool:
    """Return whether an endpoint belongs to Cyclone DDS."""
    return bool(endpoint.participant_key.bytes[: len(CYCLONE_DDS)] == CYCLONE_DDS)


def _client_id(endpoint: Any) -> bytes:
    """Return the clientid in an endpoint's user data; empty without one, or if the client has gone."""
    if endpoint is None or Policy.Userdata not in endpoint.qos:
        return b""
    entries: Sequence[bytes] = bytes(endpoint.qos[Policy.Userdata].data).split(b";")
    return next((entry for entry in entries if entry.startswith(b"clientid=")), b"")
