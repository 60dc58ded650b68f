"""RosbridgeServer: roslibpy, roslibjs and other rosbridge clients connect to a live simulator, without ROS."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from websockets.asyncio.server import ServerConnection

from uwsim.admission import Admission, tls_context
from uwsim.bridges.listener import STOP_S, Listener, Site, refuse_late
from uwsim.bridges.rosbridge.connection import Desk, HeardConnection, converse
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.guest_node import GuestNode
from uwsim.bridges.rosbridge.ledger import Ledger
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

HANDSHAKE_S = 60.0  # within which an answer to a request must be made
PING_S = 1.0  # between pings where guests ask who lives; a connection that does not answer ends after
PONG_S = 24.0
BEAT_S = 0.5  # in which silence is counted


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
        if ros not in (1, 2):
            raise ValueError(f"ros = {ros!r}: must be 1 or 2")
        self._live = live
        self._ros: Ros = ros
        self._limits = limits or Limits()
        self._guests = guests
        self._listener = Listener(
            (host, port),
            Admission(host, pages=origins, token=token, places=self._limits.connections),
            tls_context(certfile, keyfile),
            name="uwsim-rosbridge",
            handle=self._handle,
            clients=lambda: len(self.sessions),
            main=self._serve,
            site=site,
            max_size=self._limits.frame_bytes,
            max_queue=0,  # one frame waits, of many clients together 2 MiB each
            create_connection=HeardConnection,
            ping_interval=PING_S if guests else 20,
            ping_timeout=PONG_S if guests else 40,
            open_timeout=HANDSHAKE_S if site else 10,
        )
        self.channels: list[Channel] = []  # what clients see of the simulator; others may be put here before start
        self.services: list[Service] = []
        if live is not None:
            self.channels = served_channels(live, wire=wire, origin=origin)
            self.services = services(live.simulator)
        self.sessions: dict[str, Session] = {}
        self._connections: dict[str, HeardConnection] = {}
        self._going: set[asyncio.Future[None]] = set()
        self._numbers = itertools.count(1)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._node: SimulatorNode | None = None
        self._pool: ThreadPoolExecutor | None = None

    @property
    def port(self) -> int:
        """Where it listens. Raises RuntimeError before start."""
        return self._listener.port

    @property
    def url(self) -> str:
        """The address that clients connect to, without the token."""
        return self._listener.url

    def start(self) -> Self:
        """Listen; return itself. Raises OSError if it cannot, and warns (UserWarning) when others can connect."""
        self._listener.start()
        return self

    def stop(self) -> None:
        """Close all connections and end the thread."""
        self._listener.stop()
        if self._pool is not None:  # after the last session, which still works while the listener closes it
            self._pool.shutdown(wait=False, cancel_futures=True)

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self.stop()

    async def _serve(self, listener: Listener, ready: Callable[[], None]) -> None:
        loop = self._loop = asyncio.get_running_loop()
        ros1_typestore(), typestore()  # a third of a second, which the first client should not wait for
        self.graph = Graph(Ledger(self._limits.total_bytes))
        self.graph.silence_s = lambda name: self._connections[name].silent_s if name in self._connections else 0.0
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="uwsim-rosbridge-desk")
        self._desk = Desk(self._limits, self._pool)
        if self._live is not None:
            self._node = SimulatorNode(self._live, self.channels, self.services, self.graph, loop)
        has_time = self._live is not None or bool(self._guests)
        parameters = Parameters({"use_sim_time": "true"} if has_time else {}, lambda: self._live)
        offer_rosapi(self.graph, parameters, self._ros, self._time_ns)
        republisher = offer_tf(self.graph, loop)
        guests = [GuestNode(guest, self.graph, loop) for guest in self._guests]
        ready()
        await self._count_silence(listener.stopping)
        republisher.close()
        for guest in guests:
            guest.close()
        if self._node is not None:
            self._node.close()

    async def _count_silence(self, stopping: asyncio.Event) -> None:
        """Count for how long each connection has been silent, until the server stops."""
        while not stopping.is_set():
            with suppress(TimeoutError):
                await asyncio.wait_for(stopping.wait(), BEAT_S if self._guests else None)
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

    async def _handle(self, connection: ServerConnection) -> None:
        assert isinstance(connection, HeardConnection)
        if len(self.sessions) >= self._limits.connections:  # others came while this one shook hands
            await refuse_late(connection)
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
            give_up=lambda reason: self._dismiss(connection, reason),
        )
        self.sessions[name], self._connections[name] = session, connection
        try:
            await converse(connection, session, wakes, self._limits, self._desk)
        finally:
            del self.sessions[name], self._connections[name]
            session.close()

    def _dismiss(self, connection: HeardConnection, reason: str) -> None:
        task = asyncio.ensure_future(connection.dismiss(reason))
        self._going.add(task)
        task.add_done_callback(self._going.discard)
