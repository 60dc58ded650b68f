"""A DDS participant that transfers messages already encoded in CDR, built on part of the Cyclone DDS API."""

from __future__ import annotations

import ctypes
import os
import socket
import stat
import threading
import warnings
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from cyclonedds._clayer import ddspy_take
from cyclonedds.core import DDSException, DDSStatus, Entity, GuardCondition, ReadCondition, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.internal import DDS
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Sample, Topic

from uwsim.bridges.ros2.idl import idl_type
from uwsim.bridges.ros2.settings import PORTS_PER_DOMAIN, Ros2Settings, unicast_port

EVENTS_MAX = 64  # events returned by one wait; the next wait returns the others
UNREAD = 0x2 | 0x0C | 0x70  # unread samples, in any view or instance state
FATAL, ERROR = 1, 2  # Cyclone DDS log categories; one warning per malformed packet would let strangers fill the log
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # parameters of glibc's mallopt
KEPT_BYTES, BLOCK_BYTES = 64 << 20, 8 << 20

_library = DDS._dll_handle
_dds_write = _library.dds_write
_dds_write.argtypes, _dds_write.restype = [ctypes.c_int32, ctypes.c_void_p], ctypes.c_int32
_dds_attach = _library.dds_waitset_attach
_dds_attach.argtypes, _dds_attach.restype = [ctypes.c_int32, ctypes.c_int32, ctypes.c_ssize_t], ctypes.c_int32
_dds_wait = _library.dds_waitset_wait
_dds_wait.argtypes = [ctypes.c_int32, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int64]
_dds_wait.restype = ctypes.c_int32
_dds_delete = _library.dds_delete
_dds_delete.argtypes, _dds_delete.restype = [ctypes.c_int32], ctypes.c_int32


def keep_blocks_of_messages() -> None:
    """Make glibc keep the memory of large messages for reuse by later messages.

    By default, glibc returns freed blocks of about 100 kB or more to the system, so that every copy of such a message
    causes page faults: a picture of 1 MB takes 0.7 ms instead of 0.3. With other C libraries, this does nothing.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(M_MMAP_THRESHOLD, BLOCK_BYTES)
        mallopt(M_TRIM_THRESHOLD, KEPT_BYTES)


def keep_on_loopback(domain_id: int) -> None:
    """Restrict this process's sockets in a domain to this machine, and warn (UserWarning) if this fails.

    Cyclone DDS binds them to all addresses, even if it is configured to use only some interfaces.
    """
    first = unicast_port(domain_id, 0)
    ports = range(first, first + PORTS_PER_DOMAIN)
    if not hasattr(socket, "SO_BINDTODEVICE"):  # not Linux
        return
    for found in own_udp_sockets():
        with found:
            address, port = found.getsockname()
            if address == "0.0.0.0" and port in ports:
                try:
                    found.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"lo\0")
                except OSError as error:  # Linux before 5.7, without privileges
                    warnings.warn(f"ROS 2: UDP port {port} is open beyond this machine: {error}", stacklevel=2)


def own_udp_sockets() -> Iterator[socket.socket]:
    """Yield duplicates of this process's UDP sockets."""
    for entry in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # closed in the meantime
            if stat.S_ISSOCK(os.fstat(int(entry.name)).st_mode):
                found = socket.socket(fileno=os.dup(int(entry.name)))
                if (found.family, found.type) == (socket.AF_INET, socket.SOCK_DGRAM):
                    yield found
                else:
                    found.close()


class Domains:
    """The DDS domains of this process. Each is created only once and shared by all participants."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._domains: dict[int, tuple[str, Domain]] = {}
        self._users: Counter[int] = Counter()

    def enter(self, settings: Ros2Settings) -> None:
        """Enter a domain. Raises ValueError if this process has entered it with different settings, or OSError."""
        number, config = settings.domain_id, settings.config
        with self._lock:
            if number not in self._domains:
                keep_blocks_of_messages()
                _library.dds_set_log_mask(FATAL | ERROR)
                try:
                    self._domains[number] = config, Domain(number, config)
                except DDSException as error:
                    raise OSError(f"cannot join ROS 2 domain {number}: {error}") from None
                if settings.reach == "localhost":
                    keep_on_loopback(number)
            elif self._domains[number][0] != config:
                raise ValueError(f"ROS 2 domain {number}: this process has already joined it with other settings")
            self._users[number] += 1

    def leave(self, settings: Ros2Settings) -> None:
        """Leave a domain."""
        with self._lock:
            self._users[settings.domain_id] -= 1
            if self._users[settings.domain_id] <= 0:
                _delete(self._domains.pop(settings.domain_id)[1])


DOMAINS = Domains()


class Participant:
    """A DDS participant with CDR writers and readers on topics named as in ROS. Raises ValueError or OSError.

    `close` also deletes its writers and readers.
    """

    def __init__(self, settings: Ros2Settings, user_data: bytes) -> None:
        self.settings = settings
        DOMAINS.enter(settings)
        try:
            self._participant = DomainParticipant(settings.domain_id, Qos(Policy.Userdata(user_data)))
        except DDSException as error:
            DOMAINS.leave(settings)
            raise OSError(f"cannot join ROS 2 domain {settings.domain_id}: {error}") from None
        self._topics: dict[str, Topic[Any]] = {}
        self._is_closed = False

    @property
    def guid(self) -> bytes:
        """The participant's unique identifier in the domain, 16 bytes."""
        return bytes(self._participant.guid.bytes)

    @property
    def entity(self) -> DomainParticipant:
        """The underlying Cyclone DDS participant, for features that this class lacks."""
        return self._participant

    def writer(self, topic: str, type_name: str, qos: Qos) -> RawWriter:
        """Return a new writer."""
        writer: DataWriter[Any] = DataWriter(self._participant, self._topic(topic, type_name), qos)
        writer.set_status_mask(DDSStatus.PublicationMatched)
        return RawWriter(writer)

    def reader(self, topic: str, type_name: str, qos: Qos) -> RawReader:
        """Return a new reader."""
        reader: DataReader[Any] = DataReader(self._participant, self._topic(topic, type_name), qos)
        reader.set_status_mask(DDSStatus.SubscriptionMatched)
        return RawReader(reader)

    def wait_set(self) -> Events:
        """Return an object that can wait on several writers and readers."""
        return Events(self._participant)

    def close(self) -> None:
        """Leave the domain; other participants are notified."""
        if not self._is_closed:
            self._is_closed = True
            _delete(self._participant)
            DOMAINS.leave(self.settings)

    def _topic(self, name: str, type_name: str) -> Topic[Any]:
        if name not in self._topics:
            self._topics[name] = Topic(self._participant, name, idl_type(type_name, self.settings.distro))
        return self._topics[name]


class RawWriter:
    """Writes CDR to one topic."""

    def __init__(self, writer: DataWriter[Any]) -> None:
        self.entities: list[Entity] = [writer]
        self._writer = writer

    @property
    def guid(self) -> bytes:
        """The writer's unique identifier in the domain, 16 bytes."""
        return bytes(self._writer.guid.bytes)

    def write(self, cdr: memoryview) -> bool:
        """Write a message whose length must be a multiple of four; return whether it was accepted. Releases the GIL."""
        address = np.frombuffer(cdr, np.uint8).__array_interface__["data"][0]
        sample = Sample(address, len(cdr))
        return bool(_dds_write(self._writer._ref, ctypes.addressof(sample)) >= 0)

    def readers(self) -> int:
        """Return the number of matching readers, and clear the event that reported a change."""
        return int(self._writer.get_publication_matched_status().current_count)

    def has_best_effort_readers(self) -> bool:
        """Return whether any matching reader does not request what it has missed."""
        found = (self._writer.get_matched_subscription_data(each) for each in self._writer.get_matched_subscriptions())
        return any(each is not None and Policy.Reliability.BestEffort in each.qos for each in found)


class RawReader:
    """Reads CDR from one topic."""

    def __init__(self, reader: DataReader[Any]) -> None:
        self._reader = reader
        self.entities: list[Entity] = [ReadCondition(reader, UNREAD), reader]

    @property
    def guid(self) -> bytes:
        """The reader's unique identifier in the domain, 16 bytes."""
        return bytes(self._reader.guid.bytes)

    def take(self, limit: int) -> list[bytes]:
        """Return up to `limit` messages that have arrived."""
        taken = ddspy_take(self._reader._ref, UNREAD, limit)
        return [] if isinstance(taken, int) else [data for data, info in taken if info.valid_data]

    def writers(self) -> int:
        """Return the number of matching writers, and clear the event that reported a change."""
        return int(self._reader.get_subscription_matched_status().current_count)


class Events:
    """Waits for new messages, and for changes of the readers or writers that match local endpoints."""

    def __init__(self, participant: DomainParticipant) -> None:
        self._guard = GuardCondition(participant)
        self._set = WaitSet(participant)
        self._sources: list[Any] = []
        self._found = (ctypes.c_ssize_t * EVENTS_MAX)()
        self._put: deque[object] = deque()
        self._attach(self._guard, None)

    def attach(self, source: Any) -> None:
        """Add a source to wait for: a RawWriter, a RawReader, or any object with the same attribute `entities`."""
        for entity in source.entities:
            self._attach(entity, source)

    def put(self, source: object) -> None:
        """Report an event from a source that does not belong to Cyclone DDS, from any thread."""
        self._put.append(source)
        self.wake()

    def wake(self) -> None:
        """End a wait, from any thread."""
        self._guard.set(True)

    def wait(self, timeout_s: float) -> Sequence[Any]:
        """Wait for events; return their sources, or none after a timeout or `wake`. Releases the GIL."""
        count = _dds_wait(self._set._ref, ctypes.addressof(self._found), EVENTS_MAX, int(1e9 * timeout_s))
        found = [self._sources[index] for index in self._found[: max(0, min(count, EVENTS_MAX))]]
        if None in found:
            self._guard.take()
        while self._put:
            found.append(self._put.popleft())
        return [source for source in found if source is not None]

    def _attach(self, entity: Entity, source: Any) -> None:
        code = _dds_attach(self._set._ref, entity._ref, len(self._sources))
        if code < 0:
            raise OSError(f"DDS: cannot wait for {entity!r} ({code})")
        self._sources.append(source)


def _delete(entity: Entity) -> None:
    """Delete an entity and everything that belongs to it immediately, instead of when Python collects it."""
    Entity._entities.pop(entity._ref, None)
    _dds_delete(entity._ref)
