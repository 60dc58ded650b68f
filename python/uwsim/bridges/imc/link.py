"""A connection to a system that speaks IMC: a client of its TCP server, or datagrams to and from it."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Callable, Iterable
from contextlib import AsyncExitStack
from typing import Any

from uwsim.bridges.doors.conversation import first_of
from uwsim.bridges.doors.datagrams import Datagrams, resolved
from uwsim.bridges.doors.dialler import QueueDialler
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.bridges.doors.streams import Stream, stream_to
from uwsim.bridges.imc.wire import NO_SYSTEM, UNKNOWN_ENTITY, ImcError, Message, PacketReader, Sent, decoded, encoded

TCP_PORT, LISTEN_PORT = 6002, 6001
"""DUNE's port, by TCP ("Console") and UDP, and ours for datagrams."""
PORTS = {"": TCP_PORT, "tcp": TCP_PORT, "udp": TCP_PORT, "announce": LISTEN_PORT}
FORM = EndpointForm("imc", "[VEHICLE=][tcp:|udp:|announce:]HOST[:PORT]", PORTS, sends=tuple(PORTS), needs_host=True)
HEARTBEAT_S, POLL_S = 1.0, 0.25
"""Time between heartbeats, and at most between looks at the time."""
REPORT, QUERY = 0, 1
"""The operations of EntityList."""
FIRST_ENTITY = 128
"""The first of our entities' numbers; those of DUNE's tasks begin with 0."""

logger = logging.getLogger("uwsim.imc")


def parsed(text: str) -> Endpoint:
    """Return the endpoint of a system; without a kind, it is TCP. "announce" is for consoles. Raises ValueError."""
    found = FORM.parse(text)
    if found.kind == "announce" and (not re.fullmatch(r"\d{1,3}(\.\d{1,3}){3}", found.host) or found.host == "0.0.0.0"):
        raise ValueError(f"imc = '{text[:80]}': announce must have an address of this machine, such as 127.0.0.1")
    return found._replace(kind=found.kind or "tcp")


class Identity:
    """Under which system and entities messages are sent.

    system: its number; None for that of the peer, of which uwsim then is a part: the first message from there states
    it. Entities have the number that the peer's list states for their label, otherwise one of our own.
    """

    def __init__(self, system: int | None) -> None:
        self.is_part = system is None
        self.system = NO_SYSTEM if system is None else system
        self._of_peer: dict[str, int] = {}
        self._own: dict[str, int] = {}

    def learn(self, message: Message) -> None:
        """Take the peer's number and list from one of its messages."""
        if not self.is_part:
            return
        if self.system == NO_SYSTEM:
            self.system = message.source
        if message.name == "EntityList" and message.content["op"] == REPORT and message.source == self.system:
            for entry in message.content["list"].split(";"):
                label, _, number = entry.rpartition("=")
                if label and number.isdecimal() and int(number) < UNKNOWN_ENTITY:
                    self._of_peer[label] = int(number)

    def entity(self, label: str) -> int:
        """Return the number of an entity."""
        if label in self._of_peer:
            return self._of_peer[label]
        return self._own.setdefault(label, min(FIRST_ENTITY + len(self._own), UNKNOWN_ENTITY - 1))

    @property
    def list(self) -> str:
        """Our own entities, as in EntityList."""
        return ";".join(f"{label}={number}" for label, number in self._own.items())


class ImcLink(QueueDialler[Message]):
    """A connection with a heartbeat, which answers requests for our entities.

    received: called on its thread with the messages of each packet or read. met: called on its thread with the
    peer's first message. listen_port: for datagrams.
    """

    failure = ImcError

    def __init__(
        self,
        address: Endpoint,
        identity: Identity,
        received: Callable[[list[Message]], object],
        met: Callable[[Message], object] = lambda message: None,
        *,
        listen_port: int = LISTEN_PORT,
    ) -> None:
        super().__init__(str(address), logger, "uwsim-imc")
        self.address, self.identity = address, identity
        self._received, self._met, self._listen_port = received, met, listen_port
        self._is_met = False

    @property
    def is_connected(self) -> bool:
        """True while there is a connection."""
        return self.connected.is_set()

    def publish(self, said: Iterable[Sent], to: int = NO_SYSTEM) -> None:
        """Queue messages of entities, all of the present time. Does not block; may be called on any thread.

        Nothing is kept while there is no connection. to: the number of the system that they are for.
        """
        if self.is_connected:
            now_s, identity = time.time(), self.identity
            self._queue(
                Message(name, content, identity.system, identity.entity(label), now_s, to)
                for label, name, content in said
            )

    def _fail(self, error: Exception | None, wait_s: float) -> None:
        self._is_met = False
        super()._fail(error, wait_s)

    async def _connect(self) -> None:
        host, port, kind, _ = self.address
        async with AsyncExitStack() as stack:
            way: Stream | Datagrams
            if kind == "tcp":
                way = await stack.enter_async_context(stream_to(host, port))
            else:
                there = resolved(host, port)
                here = "127.0.0.1" if there[0].startswith("127.") else ""
                way = stack.enter_context(Datagrams((here, self._listen_port), to=there))
            self._join()
            self._queue([self._of("EntityList", {"op": QUERY})])
            await first_of(self._listen(way), self._speak(way))

    async def _speak(self, way: Stream | Datagrams) -> None:
        beat_s = 0.0
        while True:
            messages = await self._taken(POLL_S)
            if (now_s := time.monotonic()) - beat_s > HEARTBEAT_S:
                beat_s = now_s
                messages.append(self._of("Heartbeat", {}))
            for each in messages:
                way.send(encoded(each))

    async def _listen(self, way: Stream | Datagrams) -> None:
        reader = PacketReader()
        while True:
            if isinstance(way, Stream):
                self._take(list(reader.read(await way.read())))
            else:
                self._take(self._datagram((await way.read())[0]))

    def _datagram(self, data: bytes) -> list[Message]:
        try:
            return [decoded(data)]
        except ImcError as error:
            self._rare.warning(f"{self.address}: {error}")
            return []

    def _take(self, messages: list[Message]) -> None:
        if not messages:
            return
        for each in messages:
            self.identity.learn(each)
            is_ours = not self.identity.is_part and each.destination in (NO_SYSTEM, self.identity.system)
            if each.name == "EntityList" and each.content["op"] == QUERY and is_ours:
                answer = self._of("EntityList", {"op": REPORT, "list": self.identity.list})
                self._queue([answer._replace(destination=each.source, to_entity=each.entity)])
        if not self._is_met:
            self._is_met = True
            self._met(messages[0])
        self._received(messages)

    def _of(self, name: str, content: dict[str, Any]) -> Message:
        return Message(name, content, self.identity.system, self.identity.entity("uwsim"), time.time())
