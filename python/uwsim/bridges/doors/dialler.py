"""Dialler: a connection to a WebSocket server that is kept, on one thread that reads and writes.

OpenSSL does not allow two threads on the same connection: about one wss handshake in 4,000 then hangs (CPython 3.11 on
two busy cores).
"""

from __future__ import annotations

import asyncio
import socket
import threading
from abc import ABC, abstractmethod
from contextlib import suppress
from types import TracebackType
from typing import Self

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI
from websockets.uri import parse_uri

from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.bridges.doors.listener import STOP_S, post

CONNECT_S, CLOSE_S = 10.0, 1.0
FIRST_WAIT_S, LONGEST_WAIT_S = 0.25, 10.0
"""The shortest and the longest wait before another attempt to connect."""
REASONS: dict[type[Exception], str] = {
    ConnectionRefusedError: "connection refused: no server listens there", TimeoutError: "no response",
    socket.gaierror: "unknown host", ConnectionClosed: "the connection has ended",
}  # fmt: skip


def checked_url(url: str) -> str:
    """Return the URL of a WebSocket server. Raises ValueError for any other URL."""
    if not url.startswith(("ws://", "wss://")):
        raise ValueError(f"url = '{url}': must begin with ws:// or wss://")
    try:
        parse_uri(url).host.encode("idna")
    except (InvalidURI, ValueError) as error:  # ValueError: a port beyond 65535, a name that no host can have
        rule = f"must have a host and a port, as ws://host:{ROSBRIDGE_PORT} ({error})"
        raise ValueError(f"url = '{url}': {rule}") from None
    return url


class Dialler(ABC):
    """A connection that is made again whenever it ends, if `keeps`; otherwise `start` raises OSError without one.

    connected: set by `_converse` once the peer takes what is sent. trouble: why there is no connection; "" while there
    is one. Raises ValueError for an invalid url.
    """

    def __init__(self, url: str, *, keeps: bool, frame_bytes: int, thread: str) -> None:
        self.url, self._keeps, self._frame_bytes = checked_url(url), keeps, frame_bytes
        self.connected, self._settled, self._ready = threading.Event(), threading.Event(), threading.Event()
        self.trouble = ""
        self._thread = threading.Thread(target=lambda: asyncio.run(self._run()), name=thread, daemon=True)

    def start(self) -> Self:
        """Start connecting; return self. Raises OSError."""
        self._thread.start()
        self._ready.wait()
        if not self._keeps:
            self._settled.wait()
            if not self.connected.is_set():
                self._thread.join(STOP_S)
                raise OSError(self.trouble)
        return self

    def close(self) -> None:
        """Send what waits, disconnect and stop the thread; may be called twice."""
        if self._ready.is_set():
            post(self._loop, self._stopping.set)
            self._thread.join(STOP_S)

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    @abstractmethod
    async def _converse(self, connection: ClientConnection) -> None:
        """Exchange frames until the connection ends, calling `_join` once the peer takes them. Raises ValueError."""

    @abstractmethod
    async def _finish(self) -> None:
        """Send what waits."""

    @abstractmethod
    def _fail(self, error: Exception | None, wait_s: float) -> None:
        """Report that an attempt or a connection has ended, and when the next is made."""

    def _join(self) -> None:
        """Count as connected."""
        self.trouble = ""
        self.connected.set()
        self._settled.set()

    async def _run(self) -> None:
        self._loop, self._stopping, self._wakes = asyncio.get_running_loop(), asyncio.Event(), asyncio.Event()
        self._ready.set()
        keeping = asyncio.create_task(self._keep_connected())
        stopping = asyncio.create_task(self._stopping.wait())
        await asyncio.wait((keeping, stopping), return_when=asyncio.FIRST_COMPLETED)
        if self.connected.is_set():
            with suppress(TimeoutError, ConnectionClosed):
                async with asyncio.timeout(CLOSE_S):
                    await self._finish()
        stopping.cancel()
        keeping.cancel()
        try:
            with suppress(asyncio.CancelledError):
                await keeping
        finally:
            self._settled.set()

    async def _keep_connected(self) -> None:
        """Connect repeatedly, pausing longer after each failure; one that ends before `_join` is another."""
        wait_s = FIRST_WAIT_S
        while True:
            failure: Exception | None = None
            try:
                async with connect(
                    self.url, compression=None, max_size=self._frame_bytes, open_timeout=CONNECT_S,
                    close_timeout=CLOSE_S,
                ) as connection:  # fmt: skip
                    await self._converse(connection)
            except (OSError, TimeoutError, ConnectionClosed, InvalidHandshake, InvalidURI, ValueError) as error:
                failure = error
            has_joined = self.connected.is_set()
            self.connected.clear()
            wait_s = FIRST_WAIT_S if has_joined and not isinstance(failure, ValueError) else wait_s
            self.trouble = _why(failure)
            self._fail(failure, wait_s)
            self._settled.set()
            if not self._keeps:
                return
            await asyncio.sleep(wait_s)
            wait_s = min(2.0 * wait_s, LONGEST_WAIT_S)


def _why(error: Exception | None) -> str:
    """Return a short description of why a connection failed or ended."""
    if error is None:
        return "the connection has ended"
    if isinstance(error, InvalidHandshake):
        return f"the server there refuses a WebSocket ({error})"
    said = " ".join(str(error).split()) or type(error).__name__
    return next((why for kind, why in REASONS.items() if isinstance(error, kind)), said)
