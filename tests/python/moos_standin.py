"""A stand-in for a MOOSDB: it welcomes clients, keeps their subscriptions, answers the time, and passes on messages."""

import socket
import threading
import time
from contextlib import suppress
from typing import Self

from uwsim.bridges.moos.wire import (
    DATA,
    NOTIFY,
    POISON,
    PROTOCOL,
    REGISTER,
    TIMING,
    WELCOME,
    Message,
    PacketReader,
    encoded,
)


class StandInMoosDB:
    """Listens on a free port of 127.0.0.1. seen: all notifications, by name. names: those of the clients."""

    def __init__(self, community: str = "alpha", warp: float = 1.0, port: int = 0) -> None:
        self.community, self.warp = community, warp
        self.seen: dict[str, list[Message]] = {}
        self.names: list[str] = []
        self._clients: dict[socket.socket, set[str]] = {}
        self._socket = socket.create_server(("127.0.0.1", port))
        self.port = self._socket.getsockname()[1]
        threading.Thread(target=self._admit, daemon=True).start()

    @property
    def time_s(self) -> float:
        return time.time() * self.warp

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for each in (self._socket, *self._clients):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()

    def publish(self, **values: float | bytes) -> None:
        """Send values by variable to their subscribers."""
        for name, value in values.items():
            message = Message(NOTIFY, name, value, self.time_s, "test", self.community)
            self.seen.setdefault(name, []).append(message)
            for client, wanted in [*self._clients.items()]:
                if name in wanted:
                    client.sendall(encoded([message]))

    def last(self, name: str) -> float | bytes | None:
        return self.seen[name][-1].value if name in self.seen else None

    def _admit(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._socket.accept()
                threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        with suppress(OSError):
            assert client.recv(len(PROTOCOL), socket.MSG_WAITALL) == PROTOCOL
            reader = PacketReader()
            while data := client.recv(1 << 16):
                for each in reader.read(data):
                    self._answer(client, each)
        self._clients.pop(client, None)

    def _answer(self, client: socket.socket, message: Message) -> None:
        if message.kind == DATA:
            assert isinstance(message.value, bytes)
            if message.value.decode() in self.names:
                client.sendall(encoded([Message(POISON, "", b"already exists", self.time_s)]))
                return
            self.names.append(message.value.decode())
            self._clients[client] = set()
            client.sendall(encoded([Message(WELCOME, "", 0.0, self.time_s, community=self.community)]))
        elif message.kind == REGISTER:
            self._clients[client].add(message.name)
        elif message.kind == TIMING:
            client.sendall(encoded([message._replace(value=self.time_s)]))
        elif message.kind == NOTIFY:
            self.seen.setdefault(message.name, []).append(message)
