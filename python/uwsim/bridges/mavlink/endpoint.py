"""The socket of a MAVLink vehicle (UDP to one peer, UDP from several, or TCP) and its access control."""

from __future__ import annotations

import logging
import re
import select
import socket
import time
from contextlib import suppress
from typing import NamedTuple, Self

from uwsim.bridges.admission import warn_beyond_loopback
from uwsim.bridges.rare_log import RareLog

PORTS = {"udpout": 14550, "udpin": 14550, "tcp": 5760}
"""QGroundControl listens on UDP 14550, and connects to TCP 5760."""
MAGIC = (0xFD, 0xFE)
"""The first byte of every message in MAVLink 2 and MAVLink 1."""
PEERS_MAX = 8
SILENT_S = 10.0
PACKET_BYTES = 4096
WAITING_BYTES = 1 << 18

Peer = tuple[str, int]


class Endpoint(NamedTuple):
    """The address of a MAVLink connection. `udpout` sends to the address; `udpin` and `tcp` listen on it."""

    kind: str
    host: str
    port: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Parse "udpout", "udpin:14550", "tcp:127.0.0.1:5760" and the like. Raises ValueError."""
        kind, *rest = text.split(":")
        if kind not in PORTS or len(rest) > 2:
            raise ValueError(f"mavlink = '{text}': must be udpout, udpin or tcp, with [:HOST]:PORT if needed")
        port = rest[-1] if rest else str(PORTS[kind])
        if not re.fullmatch(r"\d{1,5}", port) or int(port) > 65535:
            raise ValueError(f"mavlink = '{text}': the port must be in [0, 65535]")
        return cls(kind, rest[0] if len(rest) == 2 else "127.0.0.1", int(port))

    def __str__(self) -> str:
        return f"{self.kind}:{self.host}:{self.port}"


class Wire:
    """An open endpoint.

    A TCP connection is admitted if its first byte is the start of a MAVLink message. Browser requests start
    differently, so no web page can command the vehicle. A UDP peer is dropped after SILENT_S of silence. At most
    PEERS_MAX peers are served; others are ignored. A peer that does not read its messages is disconnected, so that it
    cannot block. Must be used on one thread. Raises OSError.
    """

    def __init__(self, endpoint: Endpoint) -> None:
        self._kind = endpoint.kind
        self._rare = RareLog(logging.getLogger("uwsim.mavlink"))
        family, *_, address = socket.getaddrinfo(endpoint.host, endpoint.port, socket.AF_INET)[0]
        kind = socket.SOCK_STREAM if self._kind == "tcp" else socket.SOCK_DGRAM
        self._socket = socket.socket(family, kind)
        self._socket.setblocking(False)
        self._peers: dict[Peer, float] = {}  # UDP peers, with the time of their last message
        self._connections: dict[Peer, socket.socket] = {}
        self._waiting: dict[Peer, bytearray] = {}
        self._admitted: set[Peer] = set()
        try:
            if self._kind == "udpout":
                self._socket.connect(address)
                self._peers[endpoint.host, endpoint.port] = float("inf")
            else:
                warn_beyond_loopback(endpoint.host, None, tls=False)
                if self._kind == "tcp":
                    self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                self._socket.bind(address)
                if self._kind == "tcp":
                    self._socket.listen(PEERS_MAX)
        except OSError as error:
            self._socket.close()
            raise OSError(f"MAVLink {endpoint}: {error.strerror or error}") from None
        own_port = self._socket.getsockname()[1]
        self.endpoint = endpoint if self._kind == "udpout" else endpoint._replace(port=own_port)

    @property
    def peers(self) -> list[Peer]:
        """The peers to which messages are sent."""
        if self._kind == "tcp":
            return [peer for peer in self._connections if peer in self._admitted or not self._waiting[peer]]
        return list(self._peers)

    def close(self) -> None:
        """Close all sockets."""
        for connection in (*self._connections.values(), self._socket):
            connection.close()

    def receive(self, wait_s: float) -> list[tuple[Peer, bytes]]:
        """Return the data received from peers, after waiting up to wait_s for some to arrive."""
        sockets = [self._socket, *self._connections.values()]
        writers = [self._connections[peer] for peer, rest in self._waiting.items() if rest]
        ready, writable, _ = select.select(sockets, writers, [], wait_s)
        for peer, connection in list(self._connections.items()):
            if connection in writable:
                self._flush(peer)
        if self._kind == "tcp":
            return self._received_by_tcp(ready)
        found: list[tuple[Peer, bytes]] = []
        now_s = time.monotonic()
        with suppress(OSError):  # no more data, or a peer that is not listening yet
            while len(found) < 1000:
                data, peer = self._socket.recvfrom(PACKET_BYTES)
                if data[:1] and data[0] in MAGIC and self._admits(peer, now_s):
                    found.append((peer, data))
        self._peers = {peer: heard_s for peer, heard_s in self._peers.items() if now_s - heard_s < SILENT_S}
        return found

    def _admits(self, peer: Peer, now_s: float) -> bool:
        if self._kind == "udpout":
            return True
        if peer not in self._peers and len(self._peers) >= PEERS_MAX:
            self._rare.warning(f"more than {PEERS_MAX} ground stations: further ones are ignored")
            return False
        self._peers[peer] = now_s
        return True

    def _received_by_tcp(self, ready: list[socket.socket]) -> list[tuple[Peer, bytes]]:
        if self._socket in ready:
            with suppress(OSError):
                connection, peer = self._socket.accept()
                connection.setblocking(False)
                if len(self._connections) >= PEERS_MAX:
                    self._rare.warning(f"more than {PEERS_MAX} ground stations: further ones are disconnected")
                    connection.close()
                else:
                    self._connections[peer], self._waiting[peer] = connection, bytearray()
        found = []
        for peer, connection in list(self._connections.items()):
            if connection not in ready:
                continue
            try:
                data = connection.recv(1 << 16)
            except OSError:
                data = b""
            if not data or (peer not in self._admitted and data[0] not in MAGIC):
                self._drop(peer)
                continue
            self._admitted.add(peer)
            found.append((peer, data))
        return found

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

    def _drop(self, peer: Peer) -> None:
        self._connections.pop(peer).close()
        self._waiting.pop(peer)
        self._admitted.discard(peer)
