"""Sending of sentences: by UDP to one address, or by TCP to every program that connects."""

from __future__ import annotations

import logging

from uwsim.bridges.doors.datagrams import Datagrams
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.bridges.doors.streams import LineServer

PORT = 10110
"""IANA's port of NMEA 0183, by UDP and TCP."""
FORM = EndpointForm("nmea", "udp[:HOST][:PORT] or tcp[:HOST][:PORT]", {"udp": PORT, "tcp": PORT}, sends=("udp",))
"""`udp` sends to the endpoint, `tcp` listens on it."""

logger = logging.getLogger("uwsim.nmea")


class Wire:
    """Sends sentences, and reads nothing. No call blocks; must be used on one thread at a time. Raises OSError."""

    def __init__(self, target: Endpoint) -> None:
        if not target.is_local:
            logger.warning("NMEA at %s, beyond this machine, in plain text", target)
        self.target, title, there = target, f"NMEA {target}", (target.host, target.port)
        self._way: LineServer | Datagrams
        if target.kind == "tcp":
            self._way = LineServer(there, title, logger)
            self.target = target._replace(port=self._way.port)
        else:
            self._way = Datagrams(to=there, title=title)

    @property
    def count(self) -> int:
        """The number of TCP clients."""
        return len(self._way.peers) if isinstance(self._way, LineServer) else 0

    def close(self) -> None:
        """Close all sockets."""
        self._way.close()

    def send(self, sentences: list[str]) -> None:
        """Send sentences: by UDP each as a datagram."""
        if isinstance(self._way, LineServer):
            self._way.admit()
            self._way.send("".join(sentences).encode())
            return
        for each in sentences:
            self._way.send(each.encode())
