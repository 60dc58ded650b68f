"""Sending of sentences: by UDP to one address, or by TCP to every program that connects."""

from __future__ import annotations

import logging
import socket
from contextlib import suppress

from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.bridges.doors.line_server import LineServer

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
        self._server: LineServer | None = None
        self.target = target
        if target.kind == "tcp":
            self._server = LineServer(target.host, target.port, f"NMEA {target}", logger)
            self.target = target._replace(port=self._server.port)
            return
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.connect((target.host, target.port))
        except OSError as error:
            self._socket.close()
            raise OSError(f"NMEA {target}: {error.strerror or error}") from None

    @property
    def count(self) -> int:
        """The number of TCP clients."""
        return 0 if self._server is None else self._server.count

    def close(self) -> None:
        """Close all sockets."""
        (self._server or self._socket).close()

    def send(self, sentences: list[str]) -> None:
        """Send sentences: by UDP each as a datagram."""
        if self._server is not None:
            self._server.admit()
            self._server.send("".join(sentences).encode())
            return
        for each in sentences:
            with suppress(OSError):  # no program listens there
                self._socket.send(each.encode())
