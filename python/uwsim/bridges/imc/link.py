"""A connection to a system that speaks IMC: a client of its TCP server, or datagrams to and from it."""

from __future__ import annotations

import logging
import re
import socket
import time
from collections.abc import Callable, Iterable
from typing import Any

from uwsim.bridges.aboard.kept_connection import CONNECT_S, Datagrams, KeptConnection, Stream
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
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


class ImcLink(KeptConnection[Message]):
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
        self.is_connected = False
        self._is_met = False

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

    def _forget(self) -> None:
        self.is_connected = self._is_met = False

    def _connected(self) -> socket.socket:
        where = (self.address.host, self.address.port)
        if self.address.kind == "tcp":
            connection = socket.create_connection(where, CONNECT_S)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return connection
        connection = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            there = socket.getaddrinfo(*where, socket.AF_INET)[0][4]
            connection.bind(("127.0.0.1" if str(there[0]).startswith("127.") else "", self._listen_port))
            connection.connect(there)  # datagrams from other places are not received
        except OSError:
            connection.close()
            raise
        return connection

    def _converse(self) -> None:
        is_tcp = self.address.kind == "tcp"
        reader, beat_s = PacketReader(), 0.0
        with self._connected() as connection, (Stream if is_tcp else Datagrams)(connection, self._woken) as stream:
            self.is_connected = True
            self._waiting.put(self._of("EntityList", {"op": QUERY}))
            while not self._is_closed:
                messages = self._taken()
                if time.monotonic() - beat_s > HEARTBEAT_S:
                    beat_s = time.monotonic()
                    messages.append(self._of("Heartbeat", {}))
                stream.send(map(encoded, messages))
                stream.wait(POLL_S)
                for data in stream.received():
                    self._take(list(reader.read(data)) if is_tcp else self._datagram(data))

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
                self._waiting.put(answer._replace(destination=each.source, to_entity=each.entity))
        if not self._is_met:
            self._is_met = True
            self._met(messages[0])
        self._received(messages)

    def _of(self, name: str, content: dict[str, Any]) -> Message:
        return Message(name, content, self.identity.system, self.identity.entity("uwsim"), time.time())
