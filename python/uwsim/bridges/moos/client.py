"""A client of a MOOSDB: it connects, again if necessary, subscribes and publishes."""

from __future__ import annotations

import logging
import socket
import time
from collections.abc import Callable, Iterable

from uwsim.bridges.aboard.kept_connection import CONNECT_S, READ_BYTES, KeptConnection, Stream
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.bridges.moos.wire import DATA, NOTIFY, POISON, PROTOCOL, REGISTER, TIMING, Message, MoosError, PacketReader
from uwsim.bridges.moos.wire import encoded as packet_of

PORT = 9000
"""The port of a MOOSDB, unless its mission sets another."""
FORM = EndpointForm("moos", "[VEHICLE=]HOST[:PORT]", {"": PORT}, sends=("",), needs_host=True)
TIMING_S, SILENT_S = 1.0, 10.0
"""Time between questions about the time, and of silence after which a peer is lost."""

logger = logging.getLogger("uwsim.moos")


class MoosClient(KeptConnection[Message]):
    """A connection to a MOOSDB.

    name: of this application, which a community has once. names: the variables to subscribe to. received: called on
    its thread with each packet's notifications. met: called on its thread with the community's name and its time
    warp when a connection is ready. The warp is MOOS's clock, seconds since 1970 times the warp, over this machine's.
    """

    failure = MoosError

    def __init__(
        self,
        address: Endpoint,
        name: str,
        names: Iterable[str],
        received: Callable[[list[Message]], object],
        met: Callable[[str, float], object],
    ) -> None:
        super().__init__(f"MOOSDB at {address}", logger, f"uwsim-moos-{name}")
        self.address, self.name, self._names = address, name, tuple(names)
        self._received, self._met = received, met
        self.community = ""
        self.warp: float | None = None
        self._skew_s = 0.0

    @property
    def is_met(self) -> bool:
        """True while connected, with a known warp."""
        return self.warp is not None

    @property
    def time_s(self) -> float:
        """MOOS time [s]; that of the wall clock until the community is met."""
        return time.time() * (self.warp or 1.0) + self._skew_s

    def publish(self, values: Iterable[tuple[str, float | str]]) -> None:
        """Queue values by variable, all of the present time. Does not block; may be called on any thread.

        Nothing is kept for a community that is not met.
        """
        if not self.is_met:
            return
        now_s = self.time_s
        self._queue(
            Message(NOTIFY, name, value.encode() if isinstance(value, str) else float(value), now_s, self.name,
                    self.community)
            for name, value in values
        )  # fmt: skip

    def _forget(self) -> None:
        self.warp, self.community = None, ""

    def _converse(self) -> None:
        with socket.create_connection((self.address.host, self.address.port), CONNECT_S) as connection:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            reader = PacketReader()
            self._introduce(connection, reader)
            heard_s, asked_s = time.monotonic(), 0.0
            with Stream(connection, self._woken) as stream:
                while not self._is_closed:
                    now_s = time.monotonic()
                    if now_s - heard_s > SILENT_S:
                        raise OSError("silent")
                    messages = self._taken()
                    if now_s - asked_s > TIMING_S:
                        messages.insert(0, Message(TIMING, "_async_timing", 0.0, self.time_s, self.name))
                        asked_s = now_s
                    stream.send([packet_of(messages)] if messages else [])
                    stream.wait(TIMING_S / 4)
                    for data in stream.received():
                        heard_s = time.monotonic()
                        self._take(list(reader.read(data)))

    def _introduce(self, connection: socket.socket, reader: PacketReader) -> None:
        """Introduce this client, and subscribe. Raises OSError or MoosError."""
        hello = Message(DATA, "asynchronous", self.name.encode(), time.time())
        connection.sendall(PROTOCOL + packet_of([hello]))
        first = self._first(connection, reader)
        self.community = first[0].community
        self._take(first[1:])
        now_s = time.time()
        connection.sendall(
            packet_of([Message(REGISTER, name, 0.0, now_s, self.name, self.community) for name in self._names])
        )

    def _first(self, connection: socket.socket, reader: PacketReader) -> list[Message]:
        """Return the messages that begin with the welcome. Raises MoosError or OSError."""
        while True:
            data = connection.recv(READ_BYTES)
            if not data:
                raise MoosError("has closed the connection: is it a MOOSDB?")
            found = list(reader.read(data))
            if not found:
                continue
            if found[0].kind == POISON:
                reason = found[0].value
                shown = reason.decode("latin-1") if isinstance(reason, bytes) else ""
                raise MoosError(f"refuses '{self.name}': {shown[:200]}")
            return found

    def _take(self, messages: list[Message]) -> None:
        for each in messages:
            if each.kind == TIMING and isinstance(each.value, float):
                self._learn_time(each.value)
        notified = [each for each in messages if each.kind == NOTIFY]
        if notified and self.is_met:
            self._received(notified)

    def _learn_time(self, moos_s: float) -> None:
        """Find the warp, to 0.1 %: clocks that differ by a year would change it by 2 %, ones by an hour by 2e-6."""
        now_s = time.time()
        warp = round(moos_s / now_s, 3)
        if not 0.1 <= warp <= 1000:
            raise MoosError(f"a time of {moos_s:g} s: the clocks of MOOS and of this machine do not agree")
        is_new = warp != self.warp
        if is_new or abs(moos_s - now_s * warp - self._skew_s) > warp:
            # A client of the same machine shares the clock; what is left is the delay of this answer.
            skew_s = moos_s - now_s * warp
            self._skew_s = skew_s if abs(skew_s) > warp else 0.0
        self.warp = warp
        if is_new:
            self._met(self.community, warp)
