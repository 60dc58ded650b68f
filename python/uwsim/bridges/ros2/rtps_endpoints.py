"""The state of the RTPS participant: sent and received samples, other participants, and services."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.doors.waiting import Waiting
from uwsim.bridges.ros2 import rtps
from uwsim.bridges.ros2.transport import Call

KEPT = 100  # responses that may be sent again
CALLS_MAX = 100
READERS_MAX = 1000  # readers in one participant per local writer
HELD_MAX = 100
HOLD_S = 2.0


class History:
    """The samples of a local writer, as (number, submessages).

    last: the number of the last sample. If it starts at 1, an empty history can be acknowledged.
    """

    def __init__(self, writer: bytes, reader: bytes = rtps.UNKNOWN, kept: int | None = None, last: int = 0) -> None:
        self.writer, self.reader, self.last = writer, reader, last
        self.samples: deque[tuple[int, list[bytes]]] = deque(maxlen=kept)

    def add(self, payload: bytes, qos: bytes = b"") -> list[bytes]:
        """Add a sample; return its submessages."""
        self.last += 1
        self.samples.append((self.last, rtps.data(self.reader, self.writer, self.last, payload, qos)))
        return self.samples[-1][1]

    def heartbeat(self, count: int) -> bytes:
        """Return a heartbeat for all samples."""
        first = self.samples[0][0] if self.samples else self.last + 1
        return rtps.heartbeat(self.reader, self.writer, first, self.last, count)


class Track:
    """The samples received from a remote writer: all before `base` have arrived or will never arrive."""

    def __init__(self) -> None:
        self.base = 1
        self._beyond: set[int] = set()

    def add(self, number: int) -> bool:
        """Register a sample; return whether to accept it.

        A sample far beyond `base` is rejected until it is sent again.
        """
        if number < self.base or number in self._beyond or number >= self.base + 2 * rtps.WINDOW:
            return False
        self._beyond.add(number)
        self._advance()
        return True

    def skip_to(self, first: int) -> None:
        """Stop waiting for samples before `first`."""
        self.base = max(self.base, first)
        self._beyond = {number for number in self._beyond if number >= self.base}
        self._advance()

    def missing(self, last: int) -> list[int]:
        """Return the numbers to request, up to `last`."""
        upto = min(last, self.base + rtps.WINDOW - 1)
        return [number for number in range(self.base, upto + 1) if number not in self._beyond]

    def _advance(self) -> None:
        while self.base in self._beyond:
            self._beyond.remove(self.base)
            self.base += 1


class Response(NamedTuple):
    """A response held until the client's readers are ready, or until `deadline_s`."""

    history: History
    payload: bytes
    qos: bytes
    deadline_s: float


class Peer:
    """Another participant. discovery_port, port: for discovery, and for all other endpoints.

    Until a reader has received a heartbeat from a writer, it treats all samples up to the first heartbeat as history
    and skips them. A reader is in step once it has acknowledged a heartbeat; a response sent earlier could be lost.
    """

    def __init__(self, vendor: bytes, host: str, discovery_port: int, port: int) -> None:
        self.vendor = vendor
        self.discovery: Address = (host, discovery_port)
        self.address: Address = (host, port)
        self.heard_s = time.monotonic()
        self.tracks: dict[bytes, Track] = {}
        self.clients: dict[bytes, RtpsServer] = {}  # by writer
        self.awaited: dict[bytes, int] = {}  # for each local writer, the first unacknowledged sample
        self.held: list[Response] = []
        self._in_step: dict[bytes, dict[bytes, bool]] = {}  # by local writer: which readers are in step

    def add_reader(self, reader: bytes, writer: bytes) -> None:
        """Register a reliable reader of a local writer; the reader is not in step yet."""
        readers = self._in_step.setdefault(writer, {})
        if len(readers) < READERS_MAX:
            readers.setdefault(reader, False)

    def remove_reader(self, reader: bytes) -> None:
        """Forget a reader that has been deleted."""
        for readers in self._in_step.values():
            readers.pop(reader, None)

    def acknowledge(self, reader: bytes, writer: bytes, base: int) -> None:
        """Register an acknowledgement of all samples before `base`, which is 1 for a reader without a heartbeat."""
        self.awaited[writer] = base
        if base > 1:
            self.add_reader(reader, writer)
            if reader in self._in_step[writer]:
                self._in_step[writer][reader] = True

    def is_ready(self, writer: bytes) -> bool:
        """Return whether a local writer of responses has readers, all of which are in step."""
        readers = self._in_step.get(writer, {})
        return len(readers) > 0 and all(readers.values())


class RtpsServer:
    """A `Server` over DDS."""

    entities = ()  # no Cyclone DDS entities; events are reported with `put`

    def __init__(self, number: int, put: Callable[[RtpsServer], object]) -> None:
        self.reader, self.history = (
            number.to_bytes(3, "big") + b"\x04",
            History(number.to_bytes(3, "big") + b"\x03", kept=KEPT, last=1),
        )
        self._put = put
        self._calls = Waiting[Call](CALLS_MAX)

    def receive(self, call: Call) -> None:
        """Queue a call."""
        self._calls.put(call)
        self._put(self)

    def take(self, limit: int) -> list[Call]:
        """Return up to `limit` calls that have arrived."""
        return self._calls.taken(limit)
