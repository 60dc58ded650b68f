"""The socket of a MAVLink vehicle (UDP to one peer, UDP from several, or TCP) and its access control."""

from __future__ import annotations

import logging
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from uwsim.bridges.doors.admission import warn_beyond_loopback
from uwsim.bridges.doors.datagrams import Address, Datagrams, resolved
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.bridges.doors.places import Places
from uwsim.bridges.doors.streams import CLIENTS_MAX, StreamServer
from uwsim.bridges.rare_log import RareLog

PORTS = {"udpout": 14550, "udpin": 14550, "tcp": 5760}
"""QGroundControl listens on UDP 14550, and connects to TCP 5760."""
FORM = EndpointForm("mavlink", "udpout, udpin or tcp, with [:HOST][:PORT] if needed", PORTS, sends=("udpout",))
"""`udpout` sends to the endpoint; `udpin` and `tcp` listen on it."""
MAGIC = (0xFD, 0xFE)
"""The first byte of every message in MAVLink 2 and MAVLink 1."""
PEERS_MAX = CLIENTS_MAX
SILENT_S = 10.0
PACKET_BYTES = 4096
DATAGRAMS_AT_ONCE = 1000
SPAN_S, DATAGRAMS_IN_SPAN = 0.1, 100
"""Datagrams of one peer that are read: decoding takes far longer than receiving, and the buffer overflows meanwhile."""
BUFFER_BYTES = 1 << 20
UNCHECKED = ("BAD_DATA", "UNKNOWN")
"""The beginnings of pymavlink's names for what has no valid checksum, or none that it can check."""
WAITING_BYTES = 1 << 18


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
        self._parser, self._log = parser, logging.getLogger("uwsim.mavlink")
        self._rare = RareLog(self._log)
        self._fixed: list[Address] = []
        self._parsers: dict[Address, Any] = {}
        self._span_s, self._in_span = 0.0, Counter[Address]()
        self._places: Places[Address] = Places(self._forget, PEERS_MAX, SILENT_S)
        title, there = f"MAVLink {endpoint}", resolved(endpoint.host, endpoint.port)
        self._way: Datagrams | StreamServer
        if endpoint.kind == "udpout":
            self._way = Datagrams(to=there, buffer_bytes=BUFFER_BYTES, title=title)
            self._fixed = [(endpoint.host, endpoint.port)]
            self.endpoint = endpoint
            return
        warn_beyond_loopback(endpoint.host, None, tls=False)
        self._way = (
            Datagrams(there, buffer_bytes=BUFFER_BYTES, title=title)
            if endpoint.kind == "udpin"
            else StreamServer(
                there, title, self._log, unread_bytes=WAITING_BYTES, clients="ground stations", left=self._forget
            )
        )
        self.endpoint = endpoint._replace(port=self._way.port)

    @property
    def peers(self) -> list[Address]:
        """The peers to which messages are sent."""
        return self._fixed or (self._way.peers if isinstance(self._way, StreamServer) else self._places.peers())

    def close(self) -> None:
        """Close all sockets."""
        self._way.close()

    def receive(self, wait_s: float) -> list[tuple[Address, Any]]:
        """Return the messages received from peers, after waiting up to wait_s for some to arrive."""
        self._way.wait(wait_s)
        if isinstance(self._way, StreamServer):
            return self._received_by_tcp(self._way)
        found = self._received_by_udp(self._way)
        self._places.sweep()
        return found

    def _received_by_udp(self, datagrams: Datagrams) -> list[tuple[Address, Any]]:
        found: list[tuple[Address, Any]] = []
        if (now_s := time.monotonic()) >= self._span_s + SPAN_S:
            self._span_s = now_s
            self._in_span.clear()
        for data, peer in datagrams.received(DATAGRAMS_AT_ONCE):
            self._in_span[peer] += 1
            if self._in_span[peer] > DATAGRAMS_IN_SPAN:
                self._rare.warning(f"more than {DATAGRAMS_IN_SPAN} datagrams in {SPAN_S} s: others are not read")
            elif data[:1] and data[0] in MAGIC:
                parser = self._parsers.get(peer) or self._parser()
                messages = _valid(parser, data[:PACKET_BYTES])
                if messages and not self._fixed:
                    self._places.renew(peer)
                if peer in self._places or self._fixed:
                    self._parsers[peer] = parser
                found += [(peer, message) for message in messages]
        return found

    def _received_by_tcp(self, server: StreamServer) -> list[tuple[Address, Any]]:
        found: list[tuple[Address, Any]] = []
        for peer, data in server.received():
            if peer not in self._parsers:
                if data[0] not in MAGIC:
                    server.drop(peer)
                    continue
                self._parsers[peer] = self._parser()
            messages = _valid(self._parsers[peer], data)
            if messages:
                server.renew(peer)
            found += [(peer, message) for message in messages]
        return found

    def send(self, data: bytes, peer: Address | None = None) -> None:
        """Send bytes to one peer, or to all."""
        if self._fixed or isinstance(self._way, StreamServer):
            self._way.send(data, None if self._fixed else peer)
            return
        for each in self.peers if peer is None else [peer]:
            self._way.send(data, each)

    def _forget(self, peer: Address) -> None:
        """Forget a peer that has left."""
        self._parsers.pop(peer, None)


def _valid(parser: Any, data: bytes) -> list[Any]:
    """Return the messages in a peer's data whose checksum is right."""
    return [one for one in parser.parse_buffer(data) or () if not one.get_type().startswith(UNCHECKED)]
