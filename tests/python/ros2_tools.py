"""A second DDS participant for ROS 2 tests, confined to this machine and to an otherwise unused domain."""

import os
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from uwsim.bridges.ros2 import Ros2Settings
from uwsim.bridges.ros2.dds import Participant, RawReader, RawWriter
from uwsim.bridges.ros2.graph import PARTICIPANT_DATA, dds_name
from uwsim.bridges.ros2.qos import reader_qos, writer_qos
from uwsim.bridges.ros2.settings import SAFE_DOMAIN_MAX, unicast_port
from uwsim.channels.cdr import encode
from uwsim.channels.messages import from_bytes

PATIENCE_S = 30.0


def free_domain() -> int:
    """Return a DDS domain that is unused on this machine; each calling process gets a different one."""
    for attempt in range(SAFE_DOMAIN_MAX):
        domain = 1 + (os.getpid() + attempt) % SAFE_DOMAIN_MAX
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("127.0.0.1", unicast_port(domain, 0)))
            except OSError:
                continue
            return domain
    raise RuntimeError("every ROS 2 domain of this machine is in use")


def until(condition: Callable[[], Any], what: str = "it") -> Any:
    """Wait until a condition is true and return its value."""
    deadline = time.monotonic() + PATIENCE_S
    while not (value := condition()):
        assert time.monotonic() < deadline, f"{what} did not happen"
        time.sleep(0.005)
    return value


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

    def next(self, topic: str) -> Any:
        """Wait for the next message."""
        return until(lambda: self.heard(topic), f"/{topic} was silent")[0]


@contextmanager
def peer(settings: Ros2Settings) -> Iterator[Peer]:
    """Create a peer and close it afterwards."""
    found = Peer(settings)
    try:
        yield found
    finally:
        found.participant.close()
