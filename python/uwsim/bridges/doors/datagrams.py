"""Datagrams: the UDP socket of every protocol that has one."""

from __future__ import annotations

import asyncio
import select
import socket
import struct
from collections.abc import Iterator
from contextlib import suppress
from typing import Self

Address = tuple[str, int]
"""The address of a program: a host and a port."""
AT_ONCE, ALL = 64, 1 << 20
"""Datagrams that are read at once, so that no sender keeps the thread from sending, and as many as there may be."""
PACKET_BYTES = 1 << 16


def resolved(host: str, port: int) -> Address:
    """Return the IPv4 address of a host. Raises OSError."""
    found = socket.getaddrinfo(host, port, socket.AF_INET)[0][4]
    return str(found[0]), int(found[1])


class Datagrams:
    """A UDP socket that does not block. Must be used on one thread at a time. It is a context manager.

    at: where programs find it. to: the only peer. buffer_bytes: that the system keeps, or as many as it allows. title:
    as errors name it. Raises OSError.
    """

    def __init__(
        self, at: Address | None = None, *, to: Address | None = None, buffer_bytes: int = 0, title: str = ""
    ) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            if buffer_bytes:
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
            if at is not None:
                self._socket.bind(at)
            if to is not None:
                self._socket.connect(to)  # datagrams from other places are not received
        except OSError as error:
            self._socket.close()
            raise OSError(f"{title}: {error.strerror or error}") from None if title else error
        self.host: str = self._socket.getsockname()[0]
        self.port: int = self._socket.getsockname()[1]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def wait(self, wait_s: float) -> None:
        """Wait until there is something to read, at most wait_s."""
        select.select([self._socket], [], [], wait_s)

    def speak_from(self, host: str) -> None:
        """Allow broadcasts, and send what is for a multicast group from an address of this machine."""
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(host))

    def join(self, group: str, host: str) -> None:
        """Receive what is sent to a multicast group, if the network has multicast."""
        member = struct.pack("4s4s", socket.inet_aton(group), socket.inet_aton(host))
        with suppress(OSError):
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)

    def received(self, most: int = AT_ONCE) -> Iterator[tuple[bytes, Address]]:
        """Yield the datagrams that have arrived, with their senders."""
        with suppress(OSError):  # no more, or a peer that does not listen
            for _ in range(most):
                yield self._socket.recvfrom(PACKET_BYTES)

    async def read(self) -> tuple[bytes, Address]:
        """Return the next datagram, with its sender, after giving others on this thread their turn."""
        while True:
            await asyncio.sleep(0)
            with suppress(ConnectionRefusedError):  # a peer that does not listen
                return await asyncio.get_running_loop().sock_recvfrom(self._socket, PACKET_BYTES)

    def send(self, data: bytes, to: Address | None = None) -> None:
        """Send a datagram to a program, or to the only peer; it is lost if no program listens there."""
        with suppress(OSError):
            if to is None:
                self._socket.send(data)
            else:
                self._socket.sendto(data, to)
