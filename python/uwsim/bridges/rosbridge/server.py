"""RosbridgeServer: connects roslibpy, roslibjs and other rosbridge clients to a live simulator, without ROS."""

from __future__ import annotations

import asyncio
import itertools
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from uwsim.bridges.actions import Offered, actions_of
from uwsim.bridges.doors.connection import HeardConnection
from uwsim.bridges.doors.conversation import Rates, Share
from uwsim.bridges.doors.listener import STOP_S, Entrance, Listener, Site
from uwsim.bridges.rosbridge.desk import Desk, Seat
from uwsim.bridges.rosbridge.graph import LOGGER, Graph
from uwsim.bridges.rosbridge.guest_node import GuestNode
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parameters import Parameters
from uwsim.bridges.rosbridge.rosapi import offer_rosapi
from uwsim.bridges.rosbridge.session import Session
from uwsim.bridges.rosbridge.simulator_node import SimulatorNode
from uwsim.bridges.rosbridge.tf_republisher import offer_tf
from uwsim.channels import Channel, Service
from uwsim.channels.delivery.feed import Readings
from uwsim.channels.families.description import descriptions
from uwsim.channels.guest import Guest
from uwsim.channels.ros.message_types import ros1_typestore
from uwsim.channels.ros.messages import Ros, typestore
from uwsim.channels.served import served_table
from uwsim.channels.table import Wire
from uwsim.live import LiveSimulator

HANDSHAKE_S = 60.0  # time limit for answering a request
PING_S = 1.0  # ping interval if guests watch for silence; a connection that does not answer is closed after PONG_S
PONG_S = 24.0
BEAT_S = 0.5  # interval at which silence is counted


class RosbridgeServer:
    """A rosbridge v2 server on an event loop in a separate thread.

        with LiveSimulator("lake") as live, RosbridgeServer(live, port=9090):
            ...

    live: the simulator that clients see. If it is None, clients see only each other and, with a feed, a recording.
    host, port: the address on which the server listens; port 0 chooses a free port, see `port`. ros: the ROS generation
    whose spelling of times and headers is used for clients whose type names are valid in both
    ("sensor_msgs/LaserScan"). origins: web pages that may connect, in addition to this machine's. token: a secret that
    clients must send: ws://HOST:PORT/?token=TOKEN. certfile, keyfile: for wss. wire, origin: the selection of topics
    and the origin of odom, by default the scenario's; see uwsim.channels.Table. channels, services, actions: replace
    these, for example with those of a shared Table. feed: shared with other sinks. guests: other peers in this process.
    site: serves HTTP on the same port, without a check of the token. Raises ValueError or OSError.
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
        wire: Wire | None = None,
        origin: str | Sequence[float] | None = None,
        channels: Iterable[Channel] | None = None,
        services: Iterable[Service] = (),
        actions: Iterable[Offered] = (),
        feed: Readings | None = None,
        guests: Sequence[Guest] = (),
        site: Site | None = None,
    ) -> None:
        if ros not in (1, 2):
            raise ValueError(f"ros = {ros!r}: must be 1 or 2")
        self._live, self._feed = live, feed
        self._ros: Ros = ros
        self._limits = limits or Limits()
        self._guests = guests
        self._share = Share(self._limits.work_share)
        self._listener: Listener[Seat] = Listener(
            Entrance(host, port, origins, token, certfile, keyfile),
            LOGGER,
            places=self._limits.connections,
            rates=Rates(self._limits.messages_per_s, self._limits.bytes_per_s),
            share=self._share,
            open_session=self._open_session,
            main=self._serve,
            site=site,
            max_size=self._limits.frame_bytes,
            ping_interval=PING_S if guests else 20,
            ping_timeout=PONG_S if guests else 40,
            open_timeout=HANDSHAKE_S if site else 10,
        )
        if live is not None and channels is None:
            table = served_table(live, wire=wire, origin=origin)
            channels, services = table.channels, table.services
            actions = actions_of(live.simulator, table)
        self.channels: list[Channel] = list(channels or ())  # may be replaced before start
        self.services: list[Service] = list(services)
        self.actions: list[Offered] = list(actions)
        self._numbers = itertools.count(1)
        self._node: SimulatorNode | None = None
        self._pool: ThreadPoolExecutor | None = None

    def __repr__(self) -> str:
        return f"<RosbridgeServer {'at ' + self.url if self._listener.is_running else 'not started'}>"

    @property
    def sessions(self) -> dict[str, Session]:
        """The clients' sessions, keyed by their names in the graph."""
        return {seat.session.name: seat.session for seat in list(self._listener.sessions.values())}

    @property
    def port(self) -> int:
        """The port on which the server listens. Raises RuntimeError before start."""
        return self._listener.port

    @property
    def url(self) -> str:
        """The address to which clients connect, without the token."""
        return self._listener.url

    def start(self) -> Self:
        """Start listening; return self. Raises OSError on failure, and warns (UserWarning) if others can connect."""
        self._listener.start()
        return self

    def stop(self) -> None:
        """Close all connections and stop the thread."""
        self._listener.stop()
        if self._pool is not None:  # after the last session, which may use the pool until the listener has closed it
            self._pool.shutdown(wait=False, cancel_futures=True)

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self.stop()

    async def _serve(self, listener: Listener[Seat], ready: Callable[[], None]) -> None:
        loop = asyncio.get_running_loop()
        ros1_typestore(), typestore()  # takes a third of a second, so it is done before the first client connects
        self.graph = Graph()
        self.graph.silence_s = self._silence_s
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="uwsim-rosbridge-desk")
        self._desk = Desk(self._share, self._pool)
        self._join(loop)
        has_time = self._node is not None or bool(self._guests)
        present = {"use_sim_time": "true"} if has_time else {}
        parameters = Parameters(present, lambda: self._live, self._described)
        self.graph.time_ns = lambda: self._time_ns() if self._live is not None else time.time_ns()
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
        """Until the server stops, count how long each connection has been silent."""
        while not stopping.is_set():
            with suppress(TimeoutError):
                await asyncio.wait_for(stopping.wait(), BEAT_S if self._guests else None)
            for connection in self._listener.sessions:
                connection.silent_s += BEAT_S

    def _silence_s(self, name: str) -> float:
        connections = list(self._listener.sessions.items())
        return next((one.silent_s for one, seat in connections if seat.session.name == name), 0.0)

    def show(
        self,
        live: LiveSimulator | None,
        channels: Iterable[Channel],
        services: Iterable[Service],
        feed: Readings | None = None,
        actions: Iterable[Offered] = (),
    ) -> None:
        """Replace the simulator that clients see with another or none. Clients stay connected and subscribed.

        Must not be called on the network thread.
        """
        loop = self._listener.loop
        if loop is None:
            raise RuntimeError("the server has not been started")

        async def change() -> None:
            if self._node is not None:
                self._node.close()
            self._live, self._feed = live, feed
            self.channels, self.services, self.actions = list(channels), list(services), list(actions)
            self._join(loop)

        asyncio.run_coroutine_threadsafe(change(), loop).result(STOP_S)

    def _join(self, loop: asyncio.AbstractEventLoop) -> None:
        """Add the current simulator or recording, if any, to the graph."""
        self._node = None
        if self._live is not None or self._feed is not None:
            self._node = SimulatorNode(
                self._live, self.channels, self.services, self._feed, self.graph, loop, self.actions
            )

    def _described(self) -> dict[str, str]:
        return {} if self._live is None else descriptions(self.channels, self._live.simulator)

    def _time_ns(self) -> int:
        return 0 if self._live is None else self._live.simulator.time_ns

    def _open_session(
        self, connection: HeardConnection, wake: Callable[[], None], give_up: Callable[[str], None]
    ) -> Seat:
        agent = "" if connection.request is None else connection.request.headers.get("User-Agent", "")
        name = f"/client_{next(self._numbers)}"
        session = Session(self.graph, name, ros=self._ros, agent=agent, limits=self._limits, wake=wake, give_up=give_up)
        return Seat(session, self._desk)
