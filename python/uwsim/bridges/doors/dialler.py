"""Dialler: a connection to another program that is kept, on one thread that reads and writes.

OpenSSL does not allow two threads on the same connection: about one wss handshake in 4,000 then hangs (CPython 3.11 on
two busy cores).
"""

from __future__ import annotations

import asyncio
import socket
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterable
from contextlib import suppress
from logging import Logger
from types import TracebackType
from typing import ClassVar, Generic, Self, TypeVar

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI
from websockets.uri import parse_uri

from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.bridges.doors.listener import STOP_S, post
from uwsim.bridges.doors.waiting import Waiting
from uwsim.bridges.rare_log import RareLog

CONNECT_S, CLOSE_S = 10.0, 1.0
FIRST_WAIT_S, LONGEST_WAIT_S = 0.25, 10.0
"""The shortest and the longest wait before another attempt to connect."""
WAITING_MAX = 10_000
"""Messages that wait to be sent; older ones are dropped."""
REASONS: dict[type[Exception], str] = {
    ConnectionRefusedError: "connection refused: no server listens there", TimeoutError: "no response",
    socket.gaierror: "unknown host", ConnectionClosed: "the connection has ended",
}  # fmt: skip
MessageT = TypeVar("MessageT")


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

    connected: set by `_join`. trouble: why there is no connection; "" while there is one. longest_wait_s: before
    another attempt. failures: the exceptions that end a connection.
    """

    failures: ClassVar[tuple[type[Exception], ...]] = (OSError, ValueError)

    def __init__(self, thread: str, *, keeps: bool = True, longest_wait_s: float = LONGEST_WAIT_S) -> None:
        self._keeps, self._longest_wait_s = keeps, longest_wait_s
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
    async def _connect(self) -> None:
        """Connect, and exchange messages until the connection ends; call `_join` once the peer takes them."""

    @abstractmethod
    async def _finish(self) -> None:
        """Send what waits, before the connection is closed."""

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
                await self._connect()
            except self.failures as error:
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
            wait_s = min(2.0 * wait_s, self._longest_wait_s)


class WebSocketDialler(Dialler):
    """A dialler of a WebSocket server. Raises ValueError for an invalid url."""

    failures = (OSError, ValueError, ConnectionClosed, InvalidHandshake, InvalidURI)

    def __init__(self, url: str, *, keeps: bool, frame_bytes: int, thread: str) -> None:
        super().__init__(thread, keeps=keeps)
        self.url, self._frame_bytes = checked_url(url), frame_bytes

    @abstractmethod
    async def _converse(self, connection: ClientConnection) -> None:
        """Exchange frames until the connection ends, calling `_join` once the peer takes them. Raises ValueError."""

    async def _connect(self) -> None:
        async with connect(
            self.url, compression=None, max_size=self._frame_bytes, open_timeout=CONNECT_S, close_timeout=CLOSE_S
        ) as connection:
            await self._converse(connection)


class QueueDialler(Dialler, Generic[MessageT]):
    """A dialler of a system that gets messages as they come: those that wait are in a bounded queue.

    where: the peer, as the log names it. failure: the protocol's exception; it ends a connection with a line in the
    log, as an OSError does.
    """

    failures = (Exception,)
    failure: ClassVar[type[Exception]] = OSError

    def __init__(self, where: str, log: Logger, thread: str) -> None:
        super().__init__(thread, longest_wait_s=1.0)
        self._where_it_is, self._log, self._rare = where, log, RareLog(log)
        self._waiting = Waiting[MessageT](WAITING_MAX)

    def _queue(self, messages: Iterable[MessageT]) -> None:
        """Queue messages, which ends a pause. Does not block; may be called on any thread."""
        for message in messages:
            self._waiting.put(message)
        if self._ready.is_set():
            post(self._loop, self._wakes.set)

    async def _taken(self, wait_s: float) -> list[MessageT]:
        """Return the messages that wait, which then no longer do, after waiting for some for wait_s at most."""
        with suppress(TimeoutError):
            async with asyncio.timeout(0.0 if self._waiting else wait_s):
                await self._wakes.wait()
        self._wakes.clear()
        return self._waiting.taken()

    async def _finish(self) -> None:
        """See Dialler; what waits is lost."""

    def _fail(self, error: Exception | None, wait_s: float) -> None:
        """See Dialler; what waits is lost."""
        self._waiting.clear()
        if isinstance(error, OSError):
            self._rare.warning(f"{self._where_it_is}: {error.strerror or error}; trying again")
        elif isinstance(error, self.failure):
            self._rare.warning(f"{self._where_it_is}: {error}")
        else:  # of what is called with messages
            self._log.error("%s: a message could not be handled", self._where_it_is, exc_info=error)


def _why(error: Exception | None) -> str:
    """Return a short description of why a connection failed or ended."""
    if error is None:
        return "the connection has ended"
    if isinstance(error, InvalidHandshake):
        return f"the server there refuses a WebSocket ({error})"
    said = " ".join(str(error).split()) or type(error).__name__
    return next((why for kind, why in REASONS.items() if isinstance(error, kind)), said)
