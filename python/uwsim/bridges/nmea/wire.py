"""Sending of sentences: by UDP to one address, or by TCP to every program that connects."""

from __future__ import annotations

import logging
import re
import socket
from contextlib import suppress
from typing import NamedTuple, Self

from uwsim.bridges.doors.hosts import checked_host
from uwsim.bridges.doors.line_server import LineServer

PORT = 10110
"""IANA's port of NMEA 0183, by UDP and TCP."""

logger = logging.getLogger("uwsim.nmea")


class Target(NamedTuple):
    """An address: `udp` sends to it, `tcp` listens on it."""

    kind: str
    host: str
    port: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Parse "udp", "tcp:10110", "udp:127.0.0.1:10110" and the like. Raises ValueError."""
        kind, *rest = text.split(":")
        if kind not in ("udp", "tcp") or len(rest) > 2:
            raise ValueError(f"nmea = '{text[:80]}': must be udp or tcp, with [:HOST]:PORT if needed")
        port = rest[-1] if rest else str(PORT)
        low = 1 if kind == "udp" else 0
        if not re.fullmatch(r"\d{1,5}", port) or not low <= int(port) <= 65535:
            raise ValueError(f"nmea = '{text[:80]}': the port must be in [{low}, 65535]")
        host = checked_host(rest[0], f"nmea = '{text[:80]}'") if len(rest) == 2 else "127.0.0.1"
        return cls(kind, host, int(port))

    def __str__(self) -> str:
        return f"{self.kind}:{self.host}:{self.port}"


class Wire:
    """Sends sentences, and reads nothing. No call blocks; must be used on one thread at a time. Raises OSError."""

    def __init__(self, target: Target) -> None:
        if target.host != "localhost" and not target.host.startswith("127."):
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
