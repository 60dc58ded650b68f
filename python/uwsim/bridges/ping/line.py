"""The line between a simulated device and its program: datagrams, or a pseudo-terminal in place of a serial port."""

from __future__ import annotations

import os
import select
import socket
import tty
from abc import ABC, abstractmethod
from contextlib import suppress

from uwsim.bridges.doors.admission import warn_beyond_loopback
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.ping.wire import Message, Reader

READ_BYTES = 1 << 12
AT_ONCE = 64
"""Datagrams that are read at once; the others wait in the system's buffer, which drops what does not fit."""


class Line(ABC):
    """A line on which messages arrive and leave. Must be used on one thread. No call but `wait` blocks.

    address: where a program finds it.
    """

    address: str

    @abstractmethod
    def fileno(self) -> int:
        """Return what can be waited for."""

    @abstractmethod
    def received(self) -> list[Message]:
        """Return the messages that have arrived."""

    @abstractmethod
    def send(self, data: bytes) -> None:
        """Send a message. What the program does not read is lost."""

    @abstractmethod
    def close(self) -> None:
        """Close it."""

    def wait(self, wait_s: float) -> None:
        """Wait until there is something to read, at most wait_s."""
        select.select([self], [], [], wait_s)


class Datagrams(Line):
    """A line by UDP. The program that sent the last valid message is the one that is answered. Raises OSError."""

    def __init__(self, host: str, port: int) -> None:
        self._peer: tuple[str, int] | None = None
        warn_beyond_loopback(host, None, tls=False)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise OSError(f"ping protocol at udp:{host}:{port}: {error.strerror or error}") from None
        self.host, self.port = self._socket.getsockname()
        self.address = f"udp:{self.host}:{self.port}"

    def fileno(self) -> int:
        """See Line."""
        return self._socket.fileno()

    def received(self) -> list[Message]:
        """See Line."""
        found: list[Message] = []
        with suppress(OSError):  # no more data, or the program has gone
            for _ in range(AT_ONCE):
                data, peer = self._socket.recvfrom(READ_BYTES)
                messages = list(Reader().read(data))
                self._peer = peer if messages else self._peer
                found += messages
        return found

    def send(self, data: bytes) -> None:
        """See Line."""
        with suppress(OSError):
            if self._peer is not None:
                self._socket.sendto(data, self._peer)

    def close(self) -> None:
        """See Line."""
        self._socket.close()


class Terminal(Line):
    """A line by a pseudo-terminal, which a program opens as a serial port. Raises OSError."""

    def __init__(self) -> None:
        self._own, self._theirs = os.openpty()  # theirs is kept open, so that programs may come and go
        tty.setraw(self._theirs)
        os.set_blocking(self._own, False)
        self._reader = Reader()
        self.address = os.ttyname(self._theirs)

    def fileno(self) -> int:
        """See Line."""
        return self._own

    def received(self) -> list[Message]:
        """See Line."""
        with suppress(OSError):
            return list(self._reader.read(os.read(self._own, READ_BYTES)))
        return []

    def send(self, data: bytes) -> None:
        """See Line."""
        with suppress(OSError):  # no program reads
            os.write(self._own, data)

    def close(self) -> None:
        """See Line."""
        os.close(self._own)
        os.close(self._theirs)


def opened(address: Endpoint) -> Line:
    """Return the line at an address. Raises OSError."""
    return Terminal() if address.kind == "pty" else Datagrams(address.host, address.port)
