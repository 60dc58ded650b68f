"""The socket of a MAVLink vehicle (UDP to one peer, UDP from several, or TCP) and its access control."""

from __future__ import annotations

import logging
import math
import select
import socket
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from uwsim.bridges.doors.admission import warn_beyond_loopback
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.bridges.doors.places import HALF_OPEN_MAX, Places
from uwsim.bridges.rare_log import RareLog

PORTS = {"udpout": 14550, "udpin": 14550, "tcp": 5760}
"""QGroundControl listens on UDP 14550, and connects to TCP 5760."""
FORM = EndpointForm("mavlink", "udpout, udpin or tcp, with [:HOST][:PORT] if needed", PORTS, sends=("udpout",))
"""`udpout` sends to the endpoint; `udpin` and `tcp` listen on it."""
MAGIC = (0xFD, 0xFE)
"""The first byte of every message in MAVLink 2 and MAVLink 1."""
PEERS_MAX = 8
SILENT_S = 10.0
PACKET_BYTES, READ_BYTES = 4096, 1 << 11
DATAGRAMS_AT_ONCE = 1000
SPAN_S, DATAGRAMS_IN_SPAN = 0.1, 100
"""Datagrams of one peer that are read: decoding takes far longer than receiving, and the buffer overflows meanwhile."""
BUFFER_BYTES = 1 << 20
UNCHECKED = ("BAD_DATA", "UNKNOWN")
"""The beginnings of pymavlink's names for what has no valid checksum, or none that it can check."""
WAITING_BYTES = 1 << 18

Peer = tuple[str, int]


class Wire:
    """An open endpoint. parser: returns a new parser of MAVLink messages, with `parse_buffer`.

    Each peer has a parser. A TCP peer gets a place, and telemetry, with its connection, as with ArduPilot's SITL, a UDP
    peer with its first valid message, of which the checksum is correct: see uwsim.bridges.doors.places. A TCP
    connection whose first byte cannot begin a MAVLink message is closed at once; browser requests start differently, so
    no web page can command the vehicle. A UDP peer goes after SILENT_S of silence, and more than 100 datagrams of one
    in 0.1 s are not read, so that it cannot keep others from being heard. A TCP peer that does not read its messages is
    disconnected, so that it cannot block. Must be used on one thread. Raises OSError.
    """

    def __init__(self, endpoint: Endpoint, parser: Callable[[], Any]) -> None:
        self._kind, self._parser = endpoint.kind, parser
        self._rare = RareLog(logging.getLogger("uwsim.mavlink"))
        family, *_, address = socket.getaddrinfo(endpoint.host, endpoint.port, socket.AF_INET)[0]
        kind = socket.SOCK_STREAM if self._kind == "tcp" else socket.SOCK_DGRAM
        self._socket = socket.socket(family, kind)
        self._socket.setblocking(False)
        self._fixed: list[Peer] = []
        self._places: Places[Peer] = Places(self._leave, PEERS_MAX, math.inf if self._kind == "tcp" else SILENT_S)
        self._parsers: dict[Peer, Any] = {}
        self._connections: dict[Peer, socket.socket] = {}
        self._waiting: dict[Peer, bytearray] = {}
        self._span_s, self._in_span = 0.0, Counter[Peer]()
        if kind == socket.SOCK_DGRAM:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)  # or as much as is allowed
        try:
            if self._kind == "udpout":
                self._socket.connect(address)
                self._fixed = [(endpoint.host, endpoint.port)]
            else:
                warn_beyond_loopback(endpoint.host, None, tls=False)
                if self._kind == "tcp":
                    self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                self._socket.bind(address)
                if self._kind == "tcp":
                    self._socket.listen(HALF_OPEN_MAX)
        except OSError as error:
            self._socket.close()
            raise OSError(f"MAVLink {endpoint}: {error.strerror or error}") from None
        own_port = self._socket.getsockname()[1]
        self.endpoint = endpoint if self._kind == "udpout" else endpoint._replace(port=own_port)

    @property
    def peers(self) -> list[Peer]:
        """The peers to which messages are sent."""
        return self._fixed or self._places.peers()

    def close(self) -> None:
        """Close all sockets."""
        for connection in (*self._connections.values(), self._socket):
            connection.close()

    def receive(self, wait_s: float) -> list[tuple[Peer, Any]]:
        """Return the messages received from peers, after waiting up to wait_s for some to arrive."""
        sockets = [self._socket, *self._connections.values()]
        writers = [self._connections[peer] for peer, rest in self._waiting.items() if rest]
        ready, writable, _ = select.select(sockets, writers, [], wait_s)
        for peer, connection in list(self._connections.items()):
            if connection in writable:
                self._flush(peer)
        found = self._received_by_tcp(ready) if self._kind == "tcp" else self._received_by_udp()
        self._places.sweep()
        return found

    def _received_by_udp(self) -> list[tuple[Peer, Any]]:
        found: list[tuple[Peer, Any]] = []
        if (now_s := time.monotonic()) >= self._span_s + SPAN_S:
            self._span_s = now_s
            self._in_span.clear()
        with suppress(OSError):  # no more data, or a peer that is not listening yet
            for _ in range(DATAGRAMS_AT_ONCE):
                data, peer = self._socket.recvfrom(PACKET_BYTES)
                self._in_span[peer] += 1
                if self._in_span[peer] > DATAGRAMS_IN_SPAN:
                    self._rare.warning(f"more than {DATAGRAMS_IN_SPAN} datagrams in {SPAN_S} s: others are not read")
                elif data[:1] and data[0] in MAGIC:
                    found += self._messages(peer, data)
        return found

    def _received_by_tcp(self, ready: list[socket.socket]) -> list[tuple[Peer, Any]]:
        found: list[tuple[Peer, Any]] = []
        for peer, connection in list(self._connections.items()):
            if connection in ready:
                found += self._read(peer)
        if self._socket in ready:
            with suppress(OSError):  # no further connection
                for _ in range(HALF_OPEN_MAX):
                    connection, peer = self._socket.accept()
                    connection.setblocking(False)
                    self._connections[peer], self._waiting[peer] = connection, bytearray()
                    self._places.admit(peer)
                    found += self._read(peer)  # before the next is accepted, which may take its place
        return found

    def _read(self, peer: Peer) -> list[tuple[Peer, Any]]:
        try:
            data = self._connections[peer].recv(READ_BYTES)
        except BlockingIOError:
            return []
        except OSError:
            data = b""
        if data and (peer in self._parsers or data[0] in MAGIC):
            return self._messages(peer, data)
        self._drop(peer)
        return []

    def _messages(self, peer: Peer, data: bytes) -> list[tuple[Peer, Any]]:
        """Return the valid messages in a peer's data; the first one gives the peer a place."""
        parser = self._parsers.get(peer) or self._parser()
        messages = [one for one in parser.parse_buffer(data) or () if not one.get_type().startswith(UNCHECKED)]
        if messages and not self._fixed:
            self._places.renew(peer)
        if peer in self._connections or peer in self._places or self._fixed:
            self._parsers[peer] = parser
        return [(peer, message) for message in messages]

    def send(self, data: bytes, peer: Peer | None = None) -> None:
        """Send bytes to one peer, or to all."""
        for each in [peer] if peer is not None else self.peers:
            if self._kind == "tcp":
                if each in self._connections:
                    self._waiting[each] += data
                    self._flush(each)
            else:
                with suppress(OSError):
                    self._socket.send(data) if self._kind == "udpout" else self._socket.sendto(data, each)

    def _flush(self, peer: Peer) -> None:
        waiting = self._waiting[peer]
        try:
            del waiting[: self._connections[peer].send(waiting)]
        except BlockingIOError:
            if len(waiting) > WAITING_BYTES:
                self._drop(peer)
        except OSError:
            self._drop(peer)

    def _leave(self, peer: Peer) -> None:
        """End the peer that the places have given up."""
        if self._kind == "tcp":
            self._rare.warning(f"more than {PEERS_MAX} ground stations: one that was silent is disconnected")
        self._drop(peer)

    def _drop(self, peer: Peer) -> None:
        self._places.discard(peer)
        self._parsers.pop(peer, None)
        self._waiting.pop(peer, None)
        connection = self._connections.pop(peer, None)
        if connection is not None:
            connection.close()
