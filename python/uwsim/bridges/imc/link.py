"""A connection to a system that speaks IMC: a client of its TCP server, or datagrams to and from it."""

from __future__ import annotations

import logging
import re
import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any, NamedTuple, Self

from uwsim.bridges.imc.wire import NO_SYSTEM, UNKNOWN_ENTITY, ImcError, Message, PacketReader, Sent, decoded, encoded
from uwsim.bridges.rare_log import RareLog

TCP_PORT, LISTEN_PORT = 6002, 6001
"""DUNE's port, by TCP ("Console") and UDP, and ours for datagrams."""
CONNECT_S, AGAIN_S, HEARTBEAT_S, POLL_S = 5.0, 1.0, 1.0, 0.25
"""Time to connect, between attempts, between heartbeats, and at most between looks at the time."""
WAITING_MAX = 10_000
"""Messages that wait to be sent; older ones are dropped."""
READ_BYTES = 1 << 16
REPORT, QUERY = 0, 1
"""The operations of EntityList."""
FIRST_ENTITY = 128
"""The first of our entities' numbers; those of DUNE's tasks begin with 0."""

logger = logging.getLogger("uwsim.imc")


class Address(NamedTuple):
    """Where a system is, and the vehicle that it steers; "" for the first one.

    kind: "tcp", "udp", or "announce" for consoles, with this machine's own address.
    """

    vehicle: str
    kind: str
    host: str
    port: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Parse "HOST:PORT", "udp:HOST:PORT", "announce:ADDRESS", or one after "VEHICLE=". Raises ValueError."""
        vehicle, _, where = text.rpartition("=")
        found = re.fullmatch(r"(?:(tcp|udp|announce):)?([^:=\s]+)(?::(\d{1,5}))?", where)
        if found is None or ("=" in text and not vehicle):
            rule = f"must be [VEHICLE=][tcp:|udp:|announce:]HOST[:PORT], such as localhost:{TCP_PORT}"
            raise ValueError(f"imc = '{text[:80]}': {rule}")
        kind, host = found[1] or "tcp", found[2]
        if kind == "announce" and (not re.fullmatch(r"\d{1,3}(\.\d{1,3}){3}", host) or host == "0.0.0.0"):
            raise ValueError(f"imc = '{text[:80]}': announce must have an address of this machine, such as 127.0.0.1")
        port = int(found[3] or (LISTEN_PORT if kind == "announce" else TCP_PORT))
        if not 1 <= port <= 65535:
            raise ValueError(f"imc = '{text[:80]}': the port must be in [1, 65535]")
        return cls(vehicle, kind, host, port)

    def __str__(self) -> str:
        return f"{self.kind}:{self.host}:{self.port}"


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


class ImcLink:
    """A thread that keeps up a connection, with a heartbeat, and answers requests for our entities.

    received: called on this thread with the messages of each packet or read. met: called on this thread with the
    peer's first message. listen_port: for datagrams. labels: of the entities that will have something to send.
    """

    def __init__(
        self,
        address: Address,
        identity: Identity,
        received: Callable[[list[Message]], object],
        met: Callable[[Message], object] = lambda message: None,
        *,
        listen_port: int = LISTEN_PORT,
    ) -> None:
        self.address, self.identity = address, identity
        self._received, self._met, self._listen_port = received, met, listen_port
        self.is_connected = False
        self._is_met = False
        self._waiting: deque[Message] = deque(maxlen=WAITING_MAX)
        self._wake, self._woken = socket.socketpair()
        self._wake.setblocking(False)
        self._rare = RareLog(logger)
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name="uwsim-imc", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self._is_closed = True
        with suppress(OSError):
            self._wake.send(b"\0")
        self._thread.join(CONNECT_S + AGAIN_S)
        self._wake.close()
        self._woken.close()

    def publish(self, said: Iterable[Sent]) -> None:
        """Queue messages of entities, all of the present time. Does not block; may be called on any thread.

        Nothing is kept while there is no connection.
        """
        if not self.is_connected:
            return
        now_s, identity = time.time(), self.identity
        for label, name, content in said:
            self._waiting.append(Message(name, content, identity.system, identity.entity(label), now_s))
        with suppress(OSError):  # it is awake, or closed
            self._wake.send(b"\0")

    def _run(self) -> None:
        while not self._is_closed:
            try:
                with self._connected() as connection:
                    self.is_connected = True
                    self._talk(connection)
            except ImcError as error:
                self._rare.warning(f"{self.address}: {error}")
            except OSError as error:
                self._rare.warning(f"{self.address}: {error.strerror or error}; trying again")
            except Exception:  # of the callbacks
                logger.exception("%s: a message could not be handled", self.address)
            self.is_connected = self._is_met = False
            self._waiting.clear()
            until_s = time.monotonic() + AGAIN_S
            while not self._is_closed and time.monotonic() < until_s:
                time.sleep(0.05)

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

    def _talk(self, connection: socket.socket) -> None:
        """Exchange messages until the connection ends. Raises OSError or ImcError."""
        connection.settimeout(0.0)
        is_tcp = self.address.kind == "tcp"
        reader, beat_s, unsent = PacketReader(), 0.0, bytearray()
        self._waiting.append(self._of("EntityList", {"op": QUERY}))
        with selectors.DefaultSelector() as selector:
            selector.register(self._woken, selectors.EVENT_READ)
            selector.register(connection, selectors.EVENT_READ)
            while not self._is_closed:
                packets = [encoded(self._waiting.popleft()) for _ in range(len(self._waiting))]
                if time.monotonic() - beat_s > HEARTBEAT_S:
                    beat_s = time.monotonic()
                    packets.append(encoded(self._of("Heartbeat", {})))
                if is_tcp:
                    unsent += b"".join(packets)
                    if len(unsent) > READ_BYTES * 16:
                        raise OSError("does not read what it is sent")
                    with suppress(BlockingIOError):
                        while unsent:
                            del unsent[: connection.send(unsent)]
                    selector.modify(connection, selectors.EVENT_READ | (selectors.EVENT_WRITE if unsent else 0))
                else:
                    for packet in packets:
                        with suppress(OSError):  # no program listens there
                            connection.send(packet)
                for key, _ in selector.select(POLL_S):
                    if key.fileobj is self._woken:
                        self._woken.recv(READ_BYTES)
                self._take(self._read(connection, reader, is_tcp))

    def _read(self, connection: socket.socket, reader: PacketReader, is_tcp: bool) -> list[Message]:
        found: list[Message] = []
        try:
            while True:
                data = connection.recv(READ_BYTES)
                if is_tcp:
                    if not data:
                        raise OSError("has closed the connection")
                    return list(reader.read(data))
                try:
                    found.append(decoded(data))
                except ImcError as error:
                    self._rare.warning(f"{self.address}: {error}")
        except BlockingIOError:
            pass
        except ConnectionRefusedError:  # no program listens there for datagrams
            if is_tcp:
                raise
        return found

    def _take(self, messages: list[Message]) -> None:
        if not messages:
            return
        for each in messages:
            self.identity.learn(each)
            is_ours = not self.identity.is_part and each.destination in (NO_SYSTEM, self.identity.system)
            if each.name == "EntityList" and each.content["op"] == QUERY and is_ours:
                answer = self._of("EntityList", {"op": REPORT, "list": self.identity.list})
                self._waiting.append(answer._replace(destination=each.source, to_entity=each.entity))
        if not self._is_met:
            self._is_met = True
            self._met(messages[0])
        self._received(messages)

    def _of(self, name: str, content: dict[str, Any]) -> Message:
        return Message(name, content, self.identity.system, self.identity.entity("uwsim"), time.time())
