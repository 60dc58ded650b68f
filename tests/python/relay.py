"""A relay in front of a local server, which can freeze as a network does: connections stay open, nothing arrives."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import suppress
from typing import Self

CHECK_S = 0.02


class Relay:
    """Forwards connections on a port of its own. is_frozen: whether it holds everything back, in both directions."""

    def __init__(self, port: int) -> None:
        self.is_frozen = False
        self._port = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._open: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self._listener.getsockname()[1]}"

    def cut(self) -> None:
        """End all connections to the server, and leave the clients' as they are."""
        for end in self._open:
            with suppress(OSError):  # has ended already
                end.shutdown(socket.SHUT_RDWR)
        self._open = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.is_frozen = False
        self._listener.close()

    def _accept(self) -> None:
        while True:
            try:
                near, _ = self._listener.accept()
            except OSError:  # closed
                return
            far = socket.create_connection(("127.0.0.1", self._port))
            self._open.append(far)
            for source, target in ((near, far), (far, near)):
                threading.Thread(target=self._forward, args=(source, target), daemon=True).start()

    def _forward(self, source: socket.socket, target: socket.socket) -> None:
        try:
            while data := source.recv(1 << 16):
                while self.is_frozen:
                    time.sleep(CHECK_S)
                target.sendall(data)
            while self.is_frozen:
                time.sleep(CHECK_S)
            target.shutdown(socket.SHUT_WR)
        except OSError:  # the other direction has ended
            return
