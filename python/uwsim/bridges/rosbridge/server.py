"""RosbridgeServer: roslibpy, roslibjs and other rosbridge clients connect to a live simulator, without ROS."""

from __future__ import annotations

import asyncio
import itertools
import threading
from collections.abc import Awaitable, Callable, Iterable, Sequence
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from uwsim.bridges.rosbridge import admission
from uwsim.bridges.rosbridge.connection import Allowance, HeardConnection, converse
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.guest_node import GuestNode
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parameters import Parameters
from uwsim.bridges.rosbridge.rosapi import offer_rosapi
from uwsim.bridges.rosbridge.session import Session
from uwsim.bridges.rosbridge.simulator_node import SimulatorNode
from uwsim.bridges.rosbridge.tf_republisher import offer_tf
from uwsim.channels import Channel, Service, services
from uwsim.channels.guest import Guest
from uwsim.channels.message_types import ros1_typestore
from uwsim.channels.messages import Ros, typestore
from uwsim.channels.served import served_channels
from uwsim.channels.table import Wire
from uwsim.live import LiveSimulator

Site = Callable[[Request], Awaitable[Response]]
"""Answers requests for pages and files, which are no WebSockets."""

STOP_S = 5.0
HANDSHAKE_S = 60.0  # within which an answer to a request must be made
PING_S = 1.0  # between pings where guests ask who lives; a connection that does not answer ends after
PONG_S = 24.0
BEAT_S = 0.5  # in which silence is counted
WRITE_LIMIT = 1 << 16  # bytes in a connection's own buffer, after which its queues fill


class RosbridgeServer:
    """A rosbridge v2 server on an event loop of its own thread.

        with LiveSimulator("lake") as live, RosbridgeServer(live, port=9090):
            ...

    live: whose channels and services clients see; None: clients see each other alone. host, port: where it listens;
    port 0 chooses one, see `port`. ros: whose spelling of times and headers a client gets that names its types as both
    generations do ("sensor_msgs/LaserScan"). origins: web pages beyond this
    machine's own that may connect. token: clients must know it: ws://HOST:PORT/?token=TOKEN. certfile, keyfile: for
    wss. wire, origin: which topics, and where odom is: see uwsim.channels. guests: other peers in this process. site:
    what is served over HTTP on the same port, without a check of the token. Raises ValueError, OSError.
    """

    def __init__(
        self,
        live: LiveSimulator | None,
        host: str = "127.0.0.1",
        port: int = 0,
        *,
        ros: Ros = 1,
        origins: Iterable[str] = (),
        token: str | None = None,
        certfile: Path | str | None = None,
        keyfile: Path | str | None = None,
        limits: Limits | None = None,
        wire: Wire = "both",
        origin: str | Sequence[float] = "world",
        guests: Sequence[Guest] = (),
        site: Site | None = None,
    ) -> None:
        if not 0 <= port <= 65535:
            raise ValueError(f"port = {port}: must be in [0, 65535]")
        if ros not in (1, 2):
            raise ValueError(f"ros = {ros!r}: must be 1 or 2")
        admission.check_token(token)
        self._live = live
        self._host, self._asked_port = host, port
        self._ros: Ros = ros
        self._door = admission.Door(origins, host)
        self._token = token
        self._tls = admission.tls_context(certfile, keyfile)
        self._limits = limits or Limits()
        self._guests = guests
        self._site = site
        self.channels: list[Channel] = []  # what clients see of the simulator; others may be put here before start
        self.services: list[Service] = []
        if live is not None:
            self.channels = served_channels(live, wire=wire, origin=origin)
            self.services = services(live.simulator)
        self.sessions: dict[str, Session] = {}
        self._connections: dict[str, HeardConnection] = {}
        self._numbers = itertools.count(1)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None
        self._failure: BaseException | None = None
        self._node: SimulatorNode | None = None
        self._port: int | None = None

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

    def start(self) -> Self:
        """Listen; return itself. Raises OSError if it cannot, and warns (UserWarning) when others can connect."""
        if self._thread is not None:
            raise RuntimeError("the server runs already")
        admission.warn_beyond_loopback(self._host, self._token, self._tls is not None)
        ready = threading.Event()
        self._failure = None
        self._thread = threading.Thread(target=self._run, args=(ready,), name="uwsim-rosbridge", daemon=True)
        self._thread.start()
        ready.wait()
        if self._failure is not None:
            self._thread.join()
            self._thread = None
            raise OSError(f"cannot listen on {self._host}:{self._asked_port}: {self._failure}")
        return self

    def stop(self) -> None:
        """Close all connections and end the thread."""
        thread, loop = self._thread, self._loop
        if thread is None or loop is None:
            return
        loop.call_soon_threadsafe(self._stopping.set)
        thread.join(STOP_S)
        self._thread = None

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self.stop()

    def _run(self, ready: threading.Event) -> None:
        try:
            asyncio.run(self._serve(ready))
        except (OSError, UnicodeError) as error:  # UnicodeError: a name that no host can have
            self._failure = error
        finally:
            ready.set()

    async def _serve(self, ready: threading.Event) -> None:
        self._loop = asyncio.get_running_loop()
        self._stopping = asyncio.Event()
        ros1_typestore(), typestore()  # a third of a second, which the first client should not wait for
        self.graph = Graph()
        self.graph.silence_s = lambda name: self._connections[name].silent_s if name in self._connections else 0.0
        self._work_s = Allowance(self._limits.work_share)
        async with self._listen() as server:
            self._port = next(iter(server.sockets)).getsockname()[1]
            if self._live is not None:
                self._node = SimulatorNode(self._live, self.channels, self.services, self.graph, self._loop)
            has_time = self._live is not None or bool(self._guests)
            parameters = Parameters({"use_sim_time": "true"} if has_time else {}, lambda: self._live)
            offer_rosapi(self.graph, parameters, self._ros, self._time_ns)
            republisher = offer_tf(self.graph, self._loop)
            guests = [GuestNode(guest, self.graph, self._loop) for guest in self._guests]
            ready.set()
            await self._count_silence()
            republisher.close()
            for guest in guests:
                guest.close()
            if self._node is not None:
                self._node.close()

    async def _count_silence(self) -> None:
        """Count for how long each connection has been silent, until the server stops."""
        while not self._stopping.is_set():
            with suppress(TimeoutError):
                await asyncio.wait_for(self._stopping.wait(), BEAT_S if self._guests else None)
            for connection in self._connections.values():
                connection.silent_s += BEAT_S

    def show(self, live: LiveSimulator | None, channels: list[Channel], services: list[Service]) -> None:
        """Give clients another simulator to see, or none; they stay connected and subscribed.

        Not to be called on the network's thread.
        """
        if self._loop is None:
            raise RuntimeError("the server has not been started")

        async def change() -> None:
            assert self._loop is not None
            if self._node is not None:
                self._node.close()
            self._live, self.channels, self.services = live, channels, services
            self._node = None if live is None else SimulatorNode(live, channels, services, self.graph, self._loop)

        asyncio.run_coroutine_threadsafe(change(), self._loop).result(STOP_S)

    def _time_ns(self) -> int:
        return 0 if self._live is None else self._live.simulator.time_ns

    def _listen(self) -> Any:
        return serve(
            self._handle,
            self._host,
            self._asked_port,
            ssl=self._tls,
            compression=None,
            process_request=self._admit,
            max_size=self._limits.frame_bytes,
            max_queue=4,
            write_limit=WRITE_LIMIT,
            create_connection=HeardConnection,
            ping_interval=PING_S if self._guests else 20,
            ping_timeout=PONG_S if self._guests else 40,
            open_timeout=HANDSHAKE_S if self._site else 10,
            close_timeout=1,
            server_header=None,
        )

    async def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        is_socket = "websocket" in request.headers.get("Upgrade", "").lower()
        reason = self._door.refusal(request, names_matter=not is_socket)
        if reason is None and self._site is not None and not is_socket:
            return await self._site(request)
        reason = reason or admission.refusal(
            request, clients=len(self.sessions), limit=self._limits.connections, token=self._token
        )
        return None if reason is None else connection.respond(*reason)

    async def _handle(self, connection: ServerConnection) -> None:
        assert isinstance(connection, HeardConnection)
        if len(self.sessions) >= self._limits.connections:  # others came while this one shook hands
            await connection.close(1013, HTTPStatus.SERVICE_UNAVAILABLE.phrase)
            return
        wakes = asyncio.Event()
        agent = "" if connection.request is None else connection.request.headers.get("User-Agent", "")
        name = f"/client_{next(self._numbers)}"
        session = Session(
            self.graph,
            name,
            ros=self._ros,
            agent=agent,
            limits=self._limits,
            wake=wakes.set,
            give_up=connection.transport.abort,  # a closing handshake would wait behind what is not read
        )
        self.sessions[name], self._connections[name] = session, connection
        try:
            await converse(connection, session, wakes, self._limits, self._work_s)
        finally:
            del self.sessions[name], self._connections[name]
            session.close()
