"""Listener: the only way in which uwsim listens for WebSockets, so that each connection passes the same admission."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from uwsim.admission import Admission, is_socket, warn_beyond_loopback

Site = Callable[[Request], Awaitable[Response]]
"""Answers requests for pages and files, which are no WebSockets."""
Main = Callable[["Listener", Callable[[], None]], Awaitable[None]]
"""Runs while the server listens. It calls its second argument when clients may come, and returns after `stopping`."""

STOP_S = 5.0
WRITE_LIMIT = 1 << 16  # bytes in a connection's own buffer, after which its queues fill


class Listener:
    """A WebSocket server on an event loop of its own thread.

    handle: carries one admitted connection. clients: returns how many there are. main: runs as long as it listens.
    site: what is served over HTTP on the same port; it checks the token itself. options: of `websockets.serve`.
    """

    def __init__(
        self,
        address: tuple[str, int],
        admission: Admission,
        tls: Any,
        *,
        name: str,
        handle: Callable[[ServerConnection], Awaitable[None]],
        clients: Callable[[], int],
        main: Main,
        site: Site | None = None,
        **options: Any,
    ) -> None:
        host, port = address
        if not 0 <= port <= 65535:
            raise ValueError(f"port = {port}: must be in [0, 65535]")
        self._host, self._asked_port = host, port
        self._admission = admission
        self._tls = tls
        self._name = name
        self._handle, self._clients, self._main, self._site = handle, clients, main, site
        self._options = options
        self._port: int | None = None
        self._thread: threading.Thread | None = None
        self._failure: BaseException | None = None
        self.loop: asyncio.AbstractEventLoop | None = None

    @property
    def port(self) -> int:
        """Where it listens. Raises RuntimeError before start."""
        if self._port is None:
            raise RuntimeError("the server has not been started")
        return self._port

    @property
    def url(self) -> str:
        """The address that clients connect to, without the token."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"{'wss' if self._tls else 'ws'}://{host}:{self.port}"

    def start(self) -> None:
        """Listen. Raises OSError if it cannot, and warns (UserWarning) when others can connect."""
        if self._thread is not None:
            raise RuntimeError("the server runs already")
        warn_beyond_loopback(self._host, self._admission.token, self._tls is not None)
        ready = threading.Event()
        self._failure = None
        self._thread = threading.Thread(target=self._run, args=(ready,), name=self._name, daemon=True)
        self._thread.start()
        ready.wait()
        if self._failure is not None:
            self._thread.join()
            self._thread = None
            raise OSError(f"cannot listen on {self._host}:{self._asked_port}: {self._failure}")

    def stop(self) -> None:
        """Close all connections and end the thread."""
        thread, loop = self._thread, self.loop
        if thread is None or loop is None:
            return
        loop.call_soon_threadsafe(self.stopping.set)
        thread.join(STOP_S)
        self._thread = None

    def _run(self, ready: threading.Event) -> None:
        try:
            asyncio.run(self._serve(ready))
        except (OSError, UnicodeError) as error:  # UnicodeError: a name that no host can have
            self._failure = error
        finally:
            ready.set()

    async def _serve(self, ready: threading.Event) -> None:
        self.loop = asyncio.get_running_loop()
        self.stopping = asyncio.Event()
        async with self._open() as server:
            self._port = next(iter(server.sockets)).getsockname()[1]
            await self._main(self, ready.set)

    def _open(self) -> Any:
        return serve(
            self._handle,
            self._host,
            self._asked_port,
            ssl=self._tls,
            compression=None,
            process_request=self._admit,
            write_limit=WRITE_LIMIT,
            close_timeout=1,
            server_header=None,
            **self._options,
        )

    async def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        asks_site = self._site is not None and not is_socket(request)
        reason = self._admission.refusal(request, clients=None if asks_site else self._clients())
        if reason is not None:
            return connection.respond(*reason)
        if asks_site:
            assert self._site is not None
            return await self._site(request)
        return None


async def refuse_late(connection: ServerConnection) -> None:
    """Close a connection whose place was taken while it shook hands."""
    await connection.close(1013, HTTPStatus.SERVICE_UNAVAILABLE.phrase)
