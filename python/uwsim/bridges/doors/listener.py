"""Listener: the only code that listens for WebSockets, so that the same access control applies to all connections."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress
from logging import Logger
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from uwsim.bridges.doors.admission import Admission, is_socket, tls_context, warn_beyond_loopback
from uwsim.bridges.doors.connection import HeardConnection, connections_of_one_server
from uwsim.bridges.doors.conversation import Rates, Session, Share, converse
from uwsim.bridges.doors.places import HALF_OPEN_S
from uwsim.bridges.rare_log import RareLog

Site = Callable[[Request], Awaitable[Response]]
"""Answers HTTP requests for pages and files, which are not WebSockets."""
S = TypeVar("S", bound=Session)
Main = Callable[["Listener[Any]", Callable[[], None]], Awaitable[None]]
"""Runs while the server listens.

It calls its second argument as soon as clients may connect, and returns once `stopping` is set.
"""
OpenSession = Callable[[HeardConnection, Callable[[], None], Callable[[str], None]], S]
"""Opens a session, given a connection and the functions that wake its writer and disconnect the client."""

STOP_S = 5.0
WRITE_LIMIT = 1 << 16  # bytes in a connection's write buffer; once it is full, the session queues fill up


class Entrance(NamedTuple):
    """Where a server listens, and whom it admits; see Admission and tls_context. port: 0 chooses a free one."""

    host: str = "127.0.0.1"
    port: int = 0
    origins: Iterable[str] = ()
    token: str | None = None
    certfile: Path | str | None = None
    keyfile: Path | str | None = None


class Listener(Generic[S]):
    """A WebSocket server on an event loop in a separate thread, with one session per client.

    places: maximum number of simultaneous clients (see Places); 0 for a server of pages alone. rates: limits on each
    client's frames. share: limits the total CPU time for the frames of all clients. open_session: called for each
    admitted connection. main: runs while the server listens. site: serves HTTP on the same port; it checks the token
    itself. options: passed to `websockets.serve`. Raises ValueError.
    """

    def __init__(
        self,
        entrance: Entrance,
        log: Logger,
        *,
        places: int,
        rates: Rates,
        share: Share,
        open_session: OpenSession[S],
        main: Main | None = None,
        site: Site | None = None,
        **options: Any,
    ) -> None:
        if not 0 <= entrance.port <= 65535:
            raise ValueError(f"port = {entrance.port}: must be in [0, 65535]")
        self._host, self._wanted_port = entrance.host, entrance.port
        self._admission = Admission(entrance.host, pages=entrance.origins, token=entrance.token, places=places)
        self._tls = tls_context(entrance.certfile, entrance.keyfile)
        self._log = log
        self._rare = RareLog(log)
        self._places, self._rates, self._share = places, rates, share
        self._open_session, self._main, self._site = open_session, main, site
        self._options = options
        self._port: int | None = None
        self._thread: threading.Thread | None = None
        self._failure: BaseException | None = None
        self._dismissals: set[asyncio.Task[None]] = set()
        self.sessions: dict[HeardConnection, S] = {}
        self.loop: asyncio.AbstractEventLoop | None = None

    @property
    def port(self) -> int:
        """The port on which the server listens. Raises RuntimeError before start."""
        if self._port is None:
            raise RuntimeError("the server has not been started")
        return self._port

    @property
    def url(self) -> str:
        """The address to which clients connect, without the token."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"{'wss' if self._tls else 'ws'}://{host}:{self.port}"

    @property
    def is_running(self) -> bool:
        """True from start to stop."""
        return self._thread is not None

    def start(self) -> None:
        """Start listening. Raises OSError on failure, and warns (UserWarning) if other machines can connect."""
        if self._thread is not None:
            raise RuntimeError("the server is already running")
        warn_beyond_loopback(self._host, self._admission.token, self._tls is not None)
        ready = threading.Event()
        self._failure = None
        name = self._log.name.replace(".", "-")
        self._thread = threading.Thread(target=self._run, args=(ready,), name=name, daemon=True)
        self._thread.start()
        ready.wait()
        if self._failure is not None:
            self._thread.join()
            self._thread = None
            raise OSError(f"cannot listen on {self._host}:{self._wanted_port}: {self._failure}")

    def stop(self) -> None:
        """Close all connections and stop the thread."""
        thread, loop = self._thread, self.loop
        if thread is None or loop is None:
            return
        loop.call_soon_threadsafe(self.stopping.set)
        thread.join(STOP_S)
        self._thread = None

    def _run(self, ready: threading.Event) -> None:
        try:
            asyncio.run(self._serve(ready))
        except (OSError, UnicodeError) as error:  # UnicodeError: an impossible host name
            self._failure = error
        finally:
            ready.set()

    async def _serve(self, ready: threading.Event) -> None:
        self.loop = asyncio.get_running_loop()
        self.loop.set_exception_handler(self._complain)
        self.stopping = asyncio.Event()
        async with self._open() as server:
            self._port = next(iter(server.sockets)).getsockname()[1]
            if self._main is None:
                ready.set()
                await self.stopping.wait()
            else:
                await self._main(self, ready.set)

    def _open(self) -> Any:
        return serve(
            self._handle,
            self._host,
            self._wanted_port,
            ssl=self._tls,
            compression=None,
            max_queue=0,  # only one frame is buffered
            create_connection=connections_of_one_server(self._places),
            process_request=self._admit,
            write_limit=WRITE_LIMIT,
            close_timeout=1,
            server_header=None,
            ssl_handshake_timeout=HALF_OPEN_S if self._tls else None,
            **self._options,
        )

    def _complain(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Log an event loop error, such as running out of file descriptors for connections."""
        error = context.get("exception")
        self._rare.warning(f"{context['message']}: {error}" if error else str(context["message"]))

    async def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        assert isinstance(connection, HeardConnection)
        connection.half_open.discard(connection)
        await self._admission.delay_wrong_token(request, str((connection.remote_address or ("?",))[0]))
        asks_site = self._site is not None and not is_socket(request)
        reason = self._admission.refusal(request, is_client=not asks_site)
        if reason is not None:
            return connection.respond(*reason)
        if asks_site:
            assert self._site is not None
            return await self._site(request)
        return None

    async def _handle(self, connection: ServerConnection) -> None:
        assert isinstance(connection, HeardConnection)
        connection.places.admit(connection)
        loop, wakes, own_thread = asyncio.get_running_loop(), asyncio.Event(), threading.get_ident()

        def wake() -> None:
            if threading.get_ident() == own_thread:
                wakes.set()
            elif not wakes.is_set():
                post(loop, wakes.set)

        def give_up(reason: str) -> None:
            self._log.warning("client %s is disconnected: %s", connection.remote_address, reason)
            post(loop, self._dismiss, connection, reason)

        session = self.sessions[connection] = self._open_session(connection, wake, give_up)
        try:
            await converse(connection, session, wakes, self._rates, self._share)
        finally:
            connection.places.discard(connection)
            del self.sessions[connection]
            session.close()

    def _dismiss(self, connection: HeardConnection, reason: str) -> None:
        task = asyncio.ensure_future(connection.dismiss(reason))
        self._dismissals.add(task)
        task.add_done_callback(self._dismissals.discard)


def post(loop: asyncio.AbstractEventLoop, function: Callable[..., object], *arguments: Any) -> None:
    """Call a function on an event loop from any thread; do nothing if the loop has ended."""
    with suppress(RuntimeError):
        loop.call_soon_threadsafe(function, *arguments)
