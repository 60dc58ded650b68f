"""A second DDS participant for ROS 2 tests, confined to this machine and to an otherwise unused domain."""

import os
import socket
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cyclonedds.idl import IdlStruct, make_idl_struct
from cyclonedds.idl import types as idl
from cyclonedds.qos import Policy
from cyclonedds.topic import Topic

from uwsim.bridges.ros2 import Ros2Settings
from uwsim.bridges.ros2.dds import Participant, RawReader, RawWriter
from uwsim.bridges.ros2.graph import PARTICIPANT_DATA, dds_name
from uwsim.bridges.ros2.idl import idl_type
from uwsim.bridges.ros2.qos import reader_qos, writer_qos
from uwsim.bridges.ros2.settings import SAFE_DOMAIN_MAX, unicast_port
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.messages import from_bytes
from uwsim.channels.ros.service_types import request_type, response_type
from waiting import until

PATIENCE_S = 180.0


DOMAINS_PER_WORKER = 20
"""Neighbours would meet: a module's domain is chosen when it is imported, but is in use only while its tests run."""


def free_domain() -> int:
    """Return a DDS domain that is unused on this machine; each process of a test run has a range of its own."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "").removeprefix("gw")
    first = DOMAINS_PER_WORKER * int(worker) if worker else os.getpid()
    for attempt in range(SAFE_DOMAIN_MAX):
        domain = 1 + (first + attempt) % SAFE_DOMAIN_MAX
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("127.0.0.1", unicast_port(domain, 0)))
            except OSError:
                continue
            return domain
    raise RuntimeError("every ROS 2 domain of this machine is in use")


class Peer:
    """A node that reads and writes topics, as an independent client would."""

    def __init__(self, settings: Ros2Settings) -> None:
        self.participant = Participant(settings, PARTICIPANT_DATA)
        self._readers: dict[str, tuple[RawReader, str]] = {}

    def writer(self, topic: str, type_name: str) -> RawWriter:
        """Return a writer that is already matched with the node."""
        writer = self.participant.writer(dds_name(topic), type_name, writer_qos(10, latched=False, user_data=b""))
        until(writer.readers, f"/{topic} had no reader")
        return writer

    def say(self, topic: str, message: Any) -> None:
        """Publish one message."""
        assert self.writer(topic, message.__msgtype__).write(encode(message))

    def listen(self, topic: str, type_name: str, *, latched: bool = False, reliable: bool = True) -> None:
        """Subscribe to a topic."""
        qos = reader_qos(100, reliable=reliable, user_data=b"", latched=latched)
        self._readers[topic] = self.participant.reader(dds_name(topic), type_name, qos), type_name

    def heard(self, topic: str) -> list[Any]:
        """Return the messages that have arrived since the last call."""
        reader, type_name = self._readers[topic]
        return [from_bytes(data, type_name) for data in reader.take(100)]

    def bytes(self, topic: str) -> list[bytes]:
        """Return the messages that have arrived since the last call, as the received CDR bytes."""
        return list(self._readers[topic][0].take(100))

    def call(self, service: str, service_type: str, **fields: Any) -> Any:
        """Call a service as rmw_cyclonedds does (rmw_node.cpp, serdata.cpp: rmw_init_cs, rmw_send_request).

        A client has one id in the user data of both its ends. Its requests begin with the instance handle of their
        writer and a sequence number, which the reply repeats.
        """
        identity = b"clientid=1.10.%x;" % id(self)
        names = (
            (f"rq/{service}Request", request_type(service_type)),
            (f"rr/{service}Reply", response_type(service_type)),
        )
        for name, kind in names:
            self.participant._topics[name] = Topic(self.participant.entity, name, _with_header(kind))
        requests = self.participant.writer(*names[0], writer_qos(10, latched=False, user_data=identity))
        replies = self.participant.reader(*names[1], reader_qos(10, reliable=True, user_data=identity))
        asked, answered = requests._writer, replies._reader
        until(
            lambda: (
                {_service_id(asked.get_matched_subscription_data(one)) for one in asked.get_matched_subscriptions()}
                & {
                    _service_id(answered.get_matched_publication_data(one))
                    for one in answered.get_matched_publications()
                }
            ),
            f"/{service} was not available",
        )
        header = struct.pack("<Qq", 0x1234_5678_9ABC_DEF0, 77)
        data = bytes(encode(build.message(request_type(service_type), **fields)))
        assert requests.write(memoryview(data[:4] + header + data[4:]))
        (reply,) = until(lambda: replies.take(10), f"the reply of /{service}")
        assert reply[:4] == b"\0\1\0\0" and reply[4:20] == header
        return from_bytes(reply[:4] + reply[20:], response_type(service_type))

    def next(self, topic: str) -> Any:
        """Wait for the next message."""
        return until(lambda: self.heard(topic), f"/{topic} was silent")[0]


def _with_header(name: str) -> type[IdlStruct]:
    """Return a request's or a response's type with the fields of cdds_request_header_t: the wheel checks raw data."""
    plain = idl_type(name, "jazzy")
    fields = {"call_client": idl.uint64, "call_sequence": idl.int64, **plain.__annotations__}
    return make_idl_struct(plain.__name__, plain.__idl_typename__, fields)


def _service_id(endpoint: Any) -> bytes:
    entries: list[bytes] = endpoint.qos[Policy.Userdata].data.split(b";")
    return next(entry for entry in entries if entry.startswith(b"serviceid="))


@contextmanager
def peer(settings: Ros2Settings) -> Iterator[Peer]:
    """Create a peer and close it afterwards."""
    found = Peer(settings)
    try:
        yield found
    finally:
        found.participant.close()
