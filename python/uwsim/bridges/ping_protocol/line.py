"""The line between a simulated device and its program: datagrams, or a pseudo-terminal in place of a serial port."""

from __future__ import annotations

import os
import select
import tty
from collections.abc import Iterator
from contextlib import suppress

from uwsim.bridges.doors.admission import warn_beyond_loopback
from uwsim.bridges.doors.datagrams import Address, Datagrams
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.ping_protocol.wire import Message, Reader

READ_BYTES = 1 << 12


class Terminal:
    """A pseudo-terminal, which a program opens as a serial port. No call but `wait` blocks. Raises OSError."""

    def __init__(self) -> None:
        self._own, self._theirs = os.openpty()  # theirs is kept open, so that programs may come and go
        tty.setraw(self._theirs)
        os.set_blocking(self._own, False)
        self.name = os.ttyname(self._theirs)

    def wait(self, wait_s: float) -> None:
        """See Datagrams."""
        select.select([self._own], [], [], wait_s)

    def received(self) -> Iterator[tuple[bytes, Address | None]]:
        """See Datagrams."""
        with suppress(OSError):
            yield os.read(self._own, READ_BYTES), None

    def send(self, data: bytes, to: Address | None) -> None:
        """See Datagrams."""
        with suppress(OSError):  # no program reads
            os.write(self._own, data)

    def close(self) -> None:
        """See Datagrams."""
        os.close(self._own)
        os.close(self._theirs)


class Line:
    """A line on which messages arrive and leave, on one thread. What the program does not read is lost.

    By UDP, the program that sent the last valid message is the one that is answered. address: where a program finds
    it. Raises OSError.
    """

    def __init__(self, at: Endpoint) -> None:
        self._reader = Reader()
        self._peer: Address | None = None
        self._way: Datagrams | Terminal
        if at.kind == "pty":
            self._way = Terminal()
            self.address = self._way.name
            return
        warn_beyond_loopback(at.host, None, tls=False)
        self._way = Datagrams((at.host, at.port), title=f"ping protocol at {at}")
        self.host, self.port = self._way.host, self._way.port
        self.address = f"udp:{self.host}:{self.port}"

    def wait(self, wait_s: float) -> None:
        """Wait until there is something to read, at most wait_s."""
        self._way.wait(wait_s)

    def received(self) -> list[Message]:
        """Return the messages that have arrived."""
        found: list[Message] = []
        for data, peer in self._way.received():
            messages = list((self._reader if peer is None else Reader()).read(data[:READ_BYTES]))
            self._peer = peer if messages else self._peer
            found += messages
        return found

    def send(self, data: bytes) -> None:
        """Send a message."""
        self._way.send(data, self._peer)

    def close(self) -> None:
        """Close it."""
        self._way.close()
