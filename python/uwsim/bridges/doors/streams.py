"""TCP for every protocol that is no WebSocket: a server of streams, one of lines, and a stream to a server."""

from __future__ import annotations

import asyncio
import select
import socket
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, suppress
from itertools import chain
from logging import Logger

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.doors.places import HALF_OPEN_MAX, Places
from uwsim.bridges.rare_log import RareLog

CLIENTS_MAX = 8
LINE_BYTES = 4096
"""The longest line, and the most that is read of a client at once."""
READ_BYTES = 1 << 16
UNSENT_BYTES = 16 * READ_BYTES
"""Bytes that a server has not read, after which it is given up."""


class StreamServer:
    """A TCP server. No call but `wait` blocks; must be used on one thread at a time.

    A client of which more than unread_bytes wait is disconnected; of more than CLIENTS_MAX, see Places. title: as error
    messages name it. clients: as the log names them. left: called with a client that is disconnected. Raises OSError.
    """

    def __init__(
        self,
        at: Address,
        title: str,
        log: Logger,
        *,
        unread_bytes: int = 0,
        clients: str = "clients",
        left: Callable[[Address], object] = lambda client: None,
    ) -> None:
        self._rare, self._unread_bytes, self._left = RareLog(log), unread_bytes, left
        self._full = f"{title}: more than {CLIENTS_MAX} {clients}: one that was silent is disconnected"
        self._clients: dict[Address, socket.socket] = {}
        self._unread: dict[Address, bytearray] = {}
        self._places: Places[Address] = Places(self._make_room, CLIENTS_MAX)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            self._socket.setblocking(False)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._socket.bind(at)
            self._socket.listen(HALF_OPEN_MAX)
        except OSError as error:
            self._socket.close()
            raise OSError(f"{title}: {error.strerror or error}") from None
        self.host, self.port = self._socket.getsockname()

    @property
    def peers(self) -> list[Address]:
        """The clients, in the order in which they would make room."""
        return self._places.peers()

    def close(self) -> None:
        """Close all sockets."""
        for each in (*self._clients.values(), self._socket):
            each.close()

    def wait(self, wait_s: float) -> None:
        """Wait until there is something to read, at most wait_s, and send what could not be sent before."""
        unread = {self._clients[peer]: peer for peer, rest in self._unread.items() if rest}
        _, writable, _ = select.select([self._socket, *self._clients.values()], list(unread), [], wait_s)
        for each in writable:
            self._flush(unread[each])

    def admit(self) -> None:
        """Accept the clients that wait."""
        for _ in self._newcomers():
            pass

    def _newcomers(self) -> Iterator[Address]:
        for _ in range(HALF_OPEN_MAX):
            try:
                client, peer = self._socket.accept()
            except OSError:  # no other client waits
                return
            client.setblocking(False)
            self._clients[peer], self._unread[peer] = client, bytearray()
            self._places.admit(peer)
            yield peer

    def _make_room(self, peer: Address) -> None:
        self._rare.warning(self._full)
        self.drop(peer)

    def received(self) -> Iterator[tuple[Address, bytes]]:
        """Accept the clients that wait; yield what has arrived, with their clients.

        What a client sends with its connection is read before the next is accepted.
        """
        for peer in chain([*self._clients], self._newcomers()):
            if peer not in self._clients:
                continue
            try:
                data = self._clients[peer].recv(LINE_BYTES)
            except BlockingIOError:
                continue
            except OSError:
                data = b""
            if data:
                yield peer, data
            else:
                self.drop(peer)

    def renew(self, peer: Address) -> None:
        """Note that a client has sent something valid."""
        self._places.renew(peer)

    def send(self, data: bytes, only: Address | None = None) -> None:
        """Send bytes to all clients, or to one."""
        for peer in [*self._clients] if only is None else [only]:
            if peer in self._clients:
                self._unread[peer] += data
                self._flush(peer)

    def _flush(self, peer: Address) -> None:
        unread = self._unread[peer]
        try:
            with suppress(BlockingIOError):
                del unread[: self._clients[peer].send(unread)]
        except OSError:
            self.drop(peer)
        else:
            if len(unread) > self._unread_bytes:
                self.drop(peer)

    def drop(self, peer: Address) -> None:
        """Disconnect a client."""
        self._places.discard(peer)
        self._unread.pop(peer, None)
        client = self._clients.pop(peer, None)
        if client is not None:
            client.close()
            self._left(peer)


class LineServer(StreamServer):
    """A server for programs that take lines of text, and that send such if its owner wants them."""

    def __init__(self, at: Address, title: str, log: Logger) -> None:
        self._rests: dict[Address, bytes] = {}
        super().__init__(at, title, log, left=lambda peer: self._rests.pop(peer, None))

    def lines(self) -> Iterator[tuple[Address, bytes]]:
        """Accept the clients that wait; yield the lines that have arrived. A longer line disconnects its client."""
        for peer, data in self.received():
            *whole, self._rests[peer] = (self._rests.get(peer, b"") + data).split(b"\n")
            if len(self._rests[peer]) > LINE_BYTES:
                self.drop(peer)
            for line in whole:
                if peer in self._clients and line.strip():
                    self.renew(peer)
                    yield peer, line


class Stream:
    """A connection to a TCP server: what it does not read yet is kept."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader, self._writer = reader, writer

    async def read(self, patience_s: float | None = None) -> bytes:
        """Return what arrives next. Raises OSError if that is nothing, or if the server has closed the connection."""
        try:
            async with asyncio.timeout(patience_s):
                data = await self._reader.read(READ_BYTES)
        except TimeoutError:
            raise OSError("silent") from None
        if not data:
            raise OSError("has closed the connection")
        return data

    def send(self, data: bytes) -> None:
        """Send bytes, or keep them. Raises OSError for a server that does not read."""
        self._writer.write(data)
        if self._writer.transport.get_write_buffer_size() > UNSENT_BYTES:
            raise OSError("does not read what it is sent")


@asynccontextmanager
async def stream_to(host: str, port: int, patience_s: float = 5.0) -> AsyncIterator[Stream]:
    """Connect to a TCP server. Raises OSError."""
    connection = await asyncio.to_thread(socket.create_connection, (host, port), patience_s)
    reader, writer = await asyncio.open_connection(sock=connection)
    try:
        yield Stream(reader, writer)
    finally:
        writer.transport.abort()
