"""WebSocket: a client connection with all network traffic on one separate thread.

websockets.sync reads on one thread and writes on another. OpenSSL does not allow this on the same connection, and about
one wss handshake in 4,000 then hangs (CPython 3.11 on two busy cores). Here, a single thread does both.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Coroutine
from concurrent.futures import Future
from threading import Lock, Thread
from typing import TypeVar

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, ConnectionClosedOK, InvalidHandshake, InvalidURI
from websockets.uri import parse_uri

CONNECT_S = 10.0
CLOSE_S = 1.0
FIRST_WAIT_S, LONGEST_WAIT_S = 0.25, 10.0
"""The shortest and the longest wait before another attempt to connect."""
FRAME_BYTES = 64 << 20

Result = TypeVar("Result")


def checked_url(url: str) -> str:
    """Return the URL of a WebSocket server. Raises ValueError for any other URL."""
    if not url.startswith(("ws://", "wss://")):
        raise ValueError(f"url = '{url}': must begin with ws:// or wss://")
    try:
        parse_uri(url).host.encode("idna")
    except (InvalidURI, ValueError) as error:  # ValueError: a port beyond 65535, a name that no host can have
        raise ValueError(f"url = '{url}': must have a host and a port, as ws://host:9090 ({error})") from None
    return url


def why_not_connected(error: Exception) -> str:
    """Return a short description of why a connection to a WebSocket server failed or ended."""
    if isinstance(error, ConnectionRefusedError):
        return "connection refused: no server listens there"
    if isinstance(error, TimeoutError):
        return "no response"
    if isinstance(error, socket.gaierror):
        return "unknown host"
    if isinstance(error, InvalidHandshake):
        return f"the server there refuses a WebSocket ({error})"
    if isinstance(error, ConnectionClosed):
        return "the connection has ended"
    return " ".join(str(error).split()) or type(error).__name__


class WebSocket:
    """A connection to a WebSocket server; all methods may be called on any thread.

    Raises OSError if the server cannot be reached, and websockets' InvalidHandshake if it refuses the connection.
    """

    def __init__(self, url: str) -> None:
        checked_url(url)
        self._loop = asyncio.new_event_loop()
        self._lock, self._is_open = Lock(), True
        self._thread = Thread(target=self._loop.run_forever, name="uwsim-websocket", daemon=True)
        self._thread.start()
        try:
            self._connection = self._begin(self._connect(url)).result()
        except BaseException:
            self._end()
            raise

    def send(self, frame: str | bytes) -> None:
        """Send a frame. Raises ConnectionClosed."""
        self._begin(self._send(frame)).result()

    def recv(self, wait_s: float) -> str | bytes:
        """Return the next frame. Raises TimeoutError after wait_s, or ConnectionClosed if the connection is closed."""
        return self._begin(self._receive(wait_s)).result()

    def close(self) -> None:
        """Disconnect; calls in progress on other threads raise ConnectionClosed."""
        with self._lock:
            was_open, self._is_open = self._is_open, False
        if was_open:
            asyncio.run_coroutine_threadsafe(self._close(), self._loop).result()
            self._end()

    def _begin(self, work: Coroutine[object, object, Result]) -> Future[Result]:
        with self._lock:
            if not self._is_open:
                work.close()
                raise ConnectionClosedOK(None, None)
            return asyncio.run_coroutine_threadsafe(work, self._loop)

    async def _connect(self, url: str) -> ClientConnection:
        return await connect(url, compression=None, max_size=FRAME_BYTES, open_timeout=CONNECT_S, close_timeout=CLOSE_S)

    async def _send(self, frame: str | bytes) -> None:
        await self._connection.send(frame)

    async def _receive(self, wait_s: float) -> str | bytes:
        return await asyncio.wait_for(self._connection.recv(), wait_s)

    async def _close(self) -> None:
        await self._connection.close()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        if others:
            await asyncio.wait(others, timeout=CLOSE_S)
        await self._loop.shutdown_default_executor()  # it was used to resolve the host name

    def _end(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
