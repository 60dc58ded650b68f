"""A stand-in for DUNE's Transports.TCP.Server: it sends what a test asks for, and keeps what it receives."""

import socket
import threading
import time
from contextlib import suppress
from typing import Any, Self

from uwsim.bridges.imc.wire import Message, PacketReader, encoded


class StandInDune:
    """Listens on a free port of 127.0.0.1, and greets with a heartbeat. seen: all messages, by name."""

    def __init__(self, system: int = 0x00D1, entities: str = "Daemon=0;DVL=33") -> None:
        self.system, self.entities = system, entities
        self.seen: dict[str, list[Message]] = {}
        self._clients: list[socket.socket] = []
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        threading.Thread(target=self._admit, daemon=True).start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for each in (self._socket, *self._clients):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()

    def send(self, name: str, **content: Any) -> None:
        """Send a message to all clients."""
        packet = encoded(Message(name, content, self.system, 9, time.time()))
        for client in [*self._clients]:
            with suppress(OSError):
                client.sendall(packet)

    def last(self, name: str) -> Message | None:
        return self.seen[name][-1] if name in self.seen else None

    def field(self, name: str, field: str) -> float:
        """Return a field of the last message of a name; NaN without one."""
        found = self.last(name)
        return float("nan") if found is None else float(found.content[field])

    def _admit(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._socket.accept()
                self._clients.append(client)
                self.send("Heartbeat")
                threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        reader = PacketReader()
        with suppress(OSError):
            while data := client.recv(1 << 16):
                for each in reader.read(data):
                    self.seen.setdefault(each.name, []).append(each)
                    if each.name == "EntityList" and each.content["op"] == 1:
                        self.send("EntityList", op=0, list=self.entities)
