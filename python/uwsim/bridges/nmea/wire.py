"""Sending of sentences: by UDP to one address, or by TCP to every program that connects."""

from __future__ import annotations

import logging
import re
import socket
from contextlib import suppress
from typing import NamedTuple, Self

from uwsim.bridges.doors.hosts import checked_host
from uwsim.bridges.rare_log import RareLog

PORT = 10110
"""IANA's port of NMEA 0183, by UDP and TCP."""
CLIENTS_MAX = 8

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
    """Sends sentences, and reads nothing. No call blocks; must be used on one thread at a time. Raises OSError.

    A TCP client that does not read what it gets is disconnected, and so is each beyond CLIENTS_MAX.
    """

    def __init__(self, target: Target) -> None:
        self._is_tcp = target.kind == "tcp"
        self._clients: list[socket.socket] = []
        self._rare = RareLog(logger)
        if target.host != "localhost" and not target.host.startswith("127."):
            logger.warning("NMEA at %s, beyond this machine, in plain text", target)
        try:
            address = socket.getaddrinfo(target.host, target.port, socket.AF_INET)[0][4]
            self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM if self._is_tcp else socket.SOCK_DGRAM)
        except OSError as error:
            raise OSError(f"NMEA {target}: {error.strerror or error}") from None
        try:
            self._socket.setblocking(False)
            if not self._is_tcp:
                self._socket.connect(address)
            else:
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                self._socket.bind(address)
                self._socket.listen(CLIENTS_MAX)
        except OSError as error:
            self._socket.close()
            raise OSError(f"NMEA {target}: {error.strerror or error}") from None
        self.target = target._replace(port=self._socket.getsockname()[1]) if self._is_tcp else target

    @property
    def count(self) -> int:
        """The number of TCP clients."""
        return len(self._clients)

    def close(self) -> None:
        """Close all sockets."""
        for each in (*self._clients, self._socket):
            each.close()

    def send(self, sentences: list[str]) -> None:
        """Send sentences: by UDP each as a datagram."""
        if not self._is_tcp:
            for each in sentences:
                with suppress(OSError):  # no program listens there
                    self._socket.send(each.encode())
            return
        self._admit()
        data = "".join(sentences).encode()
        for client in [*self._clients]:
            try:
                is_through = client.send(data) == len(data)
            except OSError:
                is_through = False
            if not is_through:
                client.close()
                self._clients.remove(client)

    def _admit(self) -> None:
        with suppress(OSError):  # no other client waits
            for _ in range(2 * CLIENTS_MAX):
                client, _ = self._socket.accept()
                if len(self._clients) >= CLIENTS_MAX:
                    self._rare.warning(f"NMEA: more than {CLIENTS_MAX} clients: another is disconnected")
                    client.close()
                    continue
                client.setblocking(False)
                self._clients.append(client)
