"""FoxgloveServer: the Foxglove app, or any client of its WebSocket protocol, sees and steers a live simulator."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from websockets.asyncio.server import ServerConnection
from websockets.typing import Subprotocol

from uwsim.admission import Admission, tls_context
from uwsim.bridges.foxglove import protocol
from uwsim.bridges.foxglove.conversation import converse
from uwsim.bridges.foxglove.offers import Offers
from uwsim.bridges.foxglove.outbox import Outbox, Room
from uwsim.bridges.foxglove.protocol import Call
from uwsim.bridges.foxglove.session import Session
from uwsim.bridges.foxglove.shows import shows_of
from uwsim.bridges.listener import Listener, refuse_late
from uwsim.bridges.rosbridge.connection import Allowance
from uwsim.channels import Channel, Service, keep_up, require_live
from uwsim.channels.feed import Feed, Readings
from uwsim.channels.message_cost import Meter
from uwsim.channels.messages import from_bytes, from_plain
from uwsim.channels.outgoing import Outgoing
from uwsim.live import LiveSimulator

PORT = 8765  # the app's default
CLIENTS_MAX = 32
FRAME_BYTES_MAX = 1 << 18
COST_BYTES, OBJECTS_MAX = 1 << 20, 500  # what a command in JSON may take, and messages within it
TIME_S = 0.05  # simulated, between two tellings of the time
WORK_SHARE = 0.3  # of a core, for the frames of all clients together
DROP_S = 2.0  # in which a client that is given up may still read why

logger = logging.getLogger("uwsim.foxglove")


class FoxgloveServer:
    """A Foxglove WebSocket server on threads of its own.

        with LiveSimulator("lake") as live, FoxgloveServer(live, channels(live.simulator)):
            ...

    Topics carry CDR with ROS 2's schemas, so that panels treat them as a robot's; /scene/* are for the 3D panel.
    Clients may publish on the topics that the simulator hears, in CDR or JSON, and call its services in JSON. A topic
    is read while somebody subscribes to it. feed: shared with other sinks. live: None with the feed of a recording,
    which hears nothing, and of whose scenes only the maps are there. port 0 chooses one, see `port`. origins, token,
    certfile, keyfile: who may connect, and encryption, as of a RosbridgeServer. Raises ValueError, OSError if it cannot
    listen, and warns (UserWarning) when others than this machine can connect.
    """

    def __init__(
        self,
        live: LiveSimulator | None,
        channels: Sequence[Channel],
        services: Sequence[Service] = (),
        *,
        host: str = "127.0.0.1",
        port: int = PORT,
        feed: Readings | None = None,
        origins: Iterable[str] = (),
        token: str | None = None,
        certfile: Path | str | None = None,
        keyfile: Path | str | None = None,
    ) -> None:
        self._live = live
        self._inputs = {channel.name: channel for channel in channels if channel.direction == "in"}
        self._services = dict(enumerate(services, start=1))
        self._sessions: set[Session] = set()
        self._listener = Listener(
            (host, port),
            Admission(host, pages=origins, token=token, places=CLIENTS_MAX),
            tls_context(certfile, keyfile),
            name="uwsim-foxglove",
            handle=self._handle,
            clients=lambda: len(self._sessions),
            main=self._serve,
            subprotocols=[Subprotocol(name) for name in protocol.SUBPROTOCOLS],
            max_size=FRAME_BYTES_MAX,
            max_queue=0,  # one frame waits
            ping_timeout=40,
        )
        self._feed = feed or Feed(require_live(live))
        self._room = Room()
        self._outgoing = Outgoing("uwsim-foxglove-write")
        self._offers = Offers(channels, self._feed, self._outgoing)
        self._offers.complete(shows_of(live, channels, self._feed, self._outgoing, self._offers.send))
        self._greeting = self._greet()
        self._pool = ThreadPoolExecutor(4, thread_name_prefix="uwsim-foxglove-service")
        try:
            self._listener.start()
        except OSError:
            self._outgoing.close()
            raise
        self._going_on = keep_up(live, channels)
        self._end_clock = self._feed.tell_time(TIME_S, self._tell_time)

    @property
    def port(self) -> int:
        """Where it listens."""
        return self._listener.port

    @property
    def url(self) -> str:
        """The address that clients connect to, without the token."""
        return self._listener.url

    def close(self) -> None:
        """Close all connections and end the threads."""
        self._end_clock()
        for subscription in self._going_on:
            subscription.cancel()
        self._listener.stop()
        self._offers.close()
        self._outgoing.close()
        self._pool.shutdown(wait=False, cancel_futures=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    # What a session needs:

    @property
    def heard(self) -> str:
        """The topics that the simulator hears."""
        return f"/{', /'.join(self._inputs)}" if self._inputs else "none"

    def subscribe(self, session: Session, offer_id: int) -> None:
        """Send a topic's messages to a session. Raises ValueError for an unknown topic."""
        self._offers.subscribe(offer_id, session.outbox, session.subscriptions[offer_id])

    def unsubscribe(self, session: Session, offer_id: int) -> None:
        """Send no more of them."""
        self._offers.unsubscribe(offer_id, session.outbox)

    def input(self, topic: str) -> Channel | None:
        """Return what hears a topic."""
        return self._inputs.get(topic)

    def apply(self, channel: Channel, encoding: str, data: bytes) -> None:
        """Give a command. Raises ValueError, RuntimeError."""
        if encoding == "cdr":
            message = from_bytes(data, channel.type)
        else:  # two characters can ask for a message of a kilobyte
            meter = Meter(COST_BYTES, objects=OBJECTS_MAX)
            message = from_plain(channel.type, protocol.read_json(data), meter=meter)
        channel.apply(require_live(self._live), message)

    def leave(self, channel: Channel) -> None:
        """Let a channel know that nobody here commands by it any more, if so."""
        named = [entry for session in self._sessions for entry in session.advertised.values() if entry is not None]
        if channel.abandoned is not None and self._live is not None and all(one is not channel for one, _ in named):
            try:
                channel.abandoned(self._live)
            except (ValueError, RuntimeError) as error:
                logger.warning("topic '%s': %s", channel.name, error)

    def call(self, call: Call, reply: Callable[[str | bytes], None]) -> None:
        """Call a service on a thread of the pool, for it may wait for steps, and reply. Raises ValueError."""
        service = self._services.get(call.service_id)
        if service is None:
            raise ValueError(f"service {call.service_id}: there is none")
        request, loop = protocol.read_json(call.data), asyncio.get_running_loop()

        def done(future: Future[dict[str, Any]]) -> None:
            _on(loop, partial(reply, _answered(call, future)))

        self._pool.submit(service.call, require_live(self._live), request).add_done_callback(done)

    # On the network's thread:

    def _greet(self) -> list[str]:
        """Return the frames that begin each conversation."""
        services = [(number, service.name, service.type) for number, service in self._services.items()]
        frames = [
            protocol.server_info("uwsim", str(time.time_ns() // 1_000_000)),
            protocol.advertisement(self._offers.offers),
        ]
        return [*frames, protocol.services_advertisement(services)] if services else frames

    async def _serve(self, listener: Listener, ready: Callable[[], None]) -> None:
        self._work_s = Allowance(WORK_SHARE)
        ready()
        await listener.stopping.wait()

    async def _handle(self, connection: ServerConnection) -> None:
        if len(self._sessions) >= CLIENTS_MAX:  # others came while this one shook hands
            await refuse_late(connection)
            return
        loop, wakes = asyncio.get_running_loop(), asyncio.Event()
        dropping: set[asyncio.Task[None]] = set()

        def wake() -> None:
            if not wakes.is_set():
                _on(loop, wakes.set)

        def give_up(reason: str) -> None:
            logger.warning("client %s is disconnected: %s", connection.remote_address, reason)
            _on(loop, lambda: dropping.add(loop.create_task(_drop(connection, reason))))

        session = Session(self, Outbox(self._room, wake, give_up))
        self._sessions.add(session)
        for frame in self._greeting:
            session.outbox.reply(frame)
        try:
            await converse(connection, session, wakes, self._work_s)
        finally:
            self._sessions.discard(session)
            session.close()

    def _tell_time(self, time_ns: int) -> None:
        """Take the time, on the simulator's thread."""
        for session in list(self._sessions):
            session.outbox.tell_time(time_ns)


async def _drop(connection: ServerConnection, reason: str) -> None:
    """Disconnect a client that does not read: it gets the reason if it reads on soon."""
    try:
        async with asyncio.timeout(DROP_S):
            await connection.close(1008, reason[:120])
    except TimeoutError:
        connection.transport.abort()


def _on(loop: asyncio.AbstractEventLoop, function: Callable[[], object]) -> None:
    with suppress(RuntimeError):  # the loop has ended
        loop.call_soon_threadsafe(function)


def _answered(call: Call, done: Future[dict[str, Any]]) -> str | bytes:
    """Return the answer; an error's text goes to the caller."""
    if done.cancelled():
        return protocol.call_failure(call, "the server stops")
    error = done.exception()
    if error is None:
        return protocol.answer(call, done.result())
    if not isinstance(error, ValueError | RuntimeError):
        logger.error("a service failed", exc_info=error)
    return protocol.call_failure(call, str(error) or type(error).__name__)
