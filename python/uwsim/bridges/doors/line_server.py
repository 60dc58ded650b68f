"""LineServer: sends text to every TCP client, and reads lines from clients if its owner wants them."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from itertools import chain
from logging import Logger

from uwsim.bridges.doors.places import HALF_OPEN_MAX, Places
from uwsim.bridges.rare_log import RareLog

CLIENTS_MAX = 8
LINE_BYTES = 4096
"""The longest line, and the most that is read of a client at once."""


class LineServer:
    """A TCP server for programs that take lines of text. No call blocks; must be used on one thread at a time.

    A client that does not read what it gets is disconnected; of more than CLIENTS_MAX, see Places. title: as error
    messages name it. Raises OSError.
    """

    def __init__(self, host: str, port: int, title: str, log: Logger) -> None:
        self._title, self._rare = title, RareLog(log)
        self._clients: dict[socket.socket, bytearray] = {}
        self._places: Places[socket.socket] = Places(self._make_room, CLIENTS_MAX)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            self._socket.setblocking(False)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._socket.bind((host, port))
            self._socket.listen(HALF_OPEN_MAX)
        except OSError as error:
            self._socket.close()
            raise OSError(f"{title}: {error.strerror or error}") from None
        self.port: int = self._socket.getsockname()[1]

    @property
    def count(self) -> int:
        """The number of clients."""
        return len(self._clients)

    def close(self) -> None:
        """Close all sockets."""
        for each in (*self._clients, self._socket):
            each.close()

    def admit(self) -> None:
        """Accept the clients that wait."""
        for _ in self._newcomers():
            pass

    def _newcomers(self) -> Iterator[socket.socket]:
        for _ in range(HALF_OPEN_MAX):
            try:
                client, _ = self._socket.accept()
            except OSError:  # no other client waits
                return
            client.setblocking(False)
            self._clients[client] = bytearray()
            self._places.admit(client)
            yield client

    def _make_room(self, client: socket.socket) -> None:
        self._rare.warning(f"{self._title}: more than {CLIENTS_MAX} clients: one that was silent is disconnected")
        self.drop(client)

    def send(self, data: bytes, only: socket.socket | None = None) -> None:
        """Send bytes to all clients, or to one."""
        for client in [*self._clients] if only is None else [only]:
            try:
                is_through = client.send(data) == len(data)
            except OSError:
                is_through = False
            if not is_through:
                self.drop(client)

    def lines(self) -> Iterator[tuple[socket.socket, bytes]]:
        """Accept the clients that wait; yield the lines that have arrived, with their clients.

        What a client sends with its connection is read before the next is accepted. A longer line disconnects it.
        """
        for client in chain([*self._clients], self._newcomers()):
            try:
                data = client.recv(LINE_BYTES)
            except BlockingIOError:
                continue
            except OSError:
                data = b""
            *whole, rest = (self._clients[client] + data).split(b"\n")
            if not data or len(rest) > LINE_BYTES:
                self.drop(client)
                continue
            self._clients[client] = bytearray(rest)
            for line in whole:
                if client in self._clients and line.strip():
                    self._places.renew(client)
                    yield client, bytes(line)

    def drop(self, client: socket.socket) -> None:
        """Disconnect a client."""
        self._places.discard(client)
        if self._clients.pop(client, None) is not None:
            client.close()
