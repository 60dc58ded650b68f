"""A client of a MOOSDB: it connects, again if necessary, subscribes and publishes."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable

from uwsim.bridges.doors.conversation import first_of
from uwsim.bridges.doors.dialler import QueueDialler
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.bridges.doors.streams import Stream, stream_to
from uwsim.bridges.moos.wire import DATA, NOTIFY, POISON, PROTOCOL, REGISTER, TIMING, Message, MoosError, PacketReader
from uwsim.bridges.moos.wire import encoded as packet_of

PORT = 9000
"""The port of a MOOSDB, unless its mission sets another."""
FORM = EndpointForm("moos", "[VEHICLE=]HOST[:PORT]", {"": PORT}, sends=("",), needs_host=True)
TIMING_S, WELCOME_S, SILENT_S = 1.0, 5.0, 10.0
"""Time between questions about the time, for a welcome, and of silence after which a peer is lost."""

logger = logging.getLogger("uwsim.moos")


class MoosClient(QueueDialler[Message]):
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

    def _fail(self, error: Exception | None, wait_s: float) -> None:
        self.warp, self.community = None, ""
        super()._fail(error, wait_s)

    async def _connect(self) -> None:
        async with stream_to(self.address.host, self.address.port) as stream:
            reader = PacketReader()
            await self._introduce(stream, reader)
            self._join()
            await first_of(self._listen(stream, reader), self._speak(stream))

    async def _listen(self, stream: Stream, reader: PacketReader) -> None:
        while True:
            self._take(list(reader.read(await stream.read(SILENT_S))))

    async def _speak(self, stream: Stream) -> None:
        asked_s = 0.0
        while True:
            messages = await self._taken(TIMING_S / 4)
            if (now_s := time.monotonic()) - asked_s > TIMING_S:
                messages.insert(0, Message(TIMING, "_async_timing", 0.0, self.time_s, self.name))
                asked_s = now_s
            if messages:
                stream.send(packet_of(messages))

    async def _introduce(self, stream: Stream, reader: PacketReader) -> None:
        """Introduce this client, and subscribe. Raises OSError or MoosError."""
        hello = Message(DATA, "asynchronous", self.name.encode(), time.time())
        stream.send(PROTOCOL + packet_of([hello]))
        first = await self._first(stream, reader)
        self.community = first[0].community
        self._take(first[1:])
        now_s = time.time()
        stream.send(packet_of([Message(REGISTER, name, 0.0, now_s, self.name, self.community) for name in self._names]))

    async def _first(self, stream: Stream, reader: PacketReader) -> list[Message]:
        """Return the messages that begin with the welcome. Raises MoosError or OSError."""
        while True:
            try:
                found = list(reader.read(await stream.read(WELCOME_S)))
            except OSError as error:
                raise MoosError(f"{error}: is it a MOOSDB?") from None
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
