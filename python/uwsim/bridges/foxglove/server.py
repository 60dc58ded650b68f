"""FoxgloveServer: lets the Foxglove app, or any client of its protocol, display and control a live simulator."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from websockets.typing import Subprotocol

from uwsim.bridges.bridge import Bridge
from uwsim.bridges.doors.connection import HeardConnection
from uwsim.bridges.doors.conversation import Rates, Share
from uwsim.bridges.doors.listener import Entrance, Listener, post
from uwsim.bridges.doors.waiting import Room
from uwsim.bridges.foxglove import protocol
from uwsim.bridges.foxglove.offers import Offers
from uwsim.bridges.foxglove.options import PORT
from uwsim.bridges.foxglove.outbox import ALL_BYTES, Outbox
from uwsim.bridges.foxglove.protocol import Call
from uwsim.bridges.foxglove.session import Session
from uwsim.bridges.foxglove.shows import shows_of
from uwsim.channels import Channel, Service
from uwsim.channels.calls.parameter_table import ParameterTable
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.delivery.outgoing import Outgoing
from uwsim.channels.ros.messages import from_bytes, from_plain
from uwsim.channels.table import checked_origin
from uwsim.live import LiveSimulator

CLIENTS_MAX = 32
FRAME_BYTES_MAX = 1 << 18
MESSAGES_MAX = 500  # within a command in JSON
TIME_S = 0.05  # simulated seconds between time messages
WORK_SHARE = 0.3  # fraction of a core available for the frames of all clients together
RATES = Rates(frames=1000.0, bytes=4e6)  # limits per client


class FoxgloveServer(Bridge):
    """A Foxglove WebSocket server that runs on separate threads.

        with LiveSimulator("lake") as live:
            table = Table(live.simulator)
            with FoxgloveServer(live, table.channels, table.services):
                ...

    Topics carry CDR with ROS 2 schemas, so that panels treat them like a robot's topics. The /scene/* topics are for
    the 3D panel. Clients may publish on command topics, in CDR or JSON, call services in JSON, and read and set the
    simulator's parameters. A topic is read only while clients subscribe to it.

    live: None if the feed plays a recording, which accepts no commands and whose only scenes are the maps. port: 0
    chooses a free one; see `port`. feed: shared with other sinks. origin: the world's origin in odom, which must match
    the Table of the channels. origins, token, certfile, keyfile: access control and encryption, as in RosbridgeServer.
    Raises ValueError, or OSError if it cannot listen, and warns (UserWarning) if other machines can connect.
    """

    peer = "a Foxglove client"

    def __init__(
        self,
        live: LiveSimulator | None,
        channels: Sequence[Channel],
        services: Sequence[Service] = (),
        *,
        host: str = "127.0.0.1",
        port: int = PORT,
        feed: Readings | None = None,
        origin: str | Sequence[float] = "world",
        origins: Iterable[str] = (),
        token: str | None = None,
        certfile: Path | str | None = None,
        keyfile: Path | str | None = None,
    ) -> None:
        origin_m = checked_origin(origin)
        super().__init__("foxglove", live, channels, services, feed)
        self._listener: Listener[Session] = Listener(
            Entrance(host, port, origins, token, certfile, keyfile),
            self.log,
            places=CLIENTS_MAX,
            rates=RATES,
            share=Share(WORK_SHARE),
            open_session=self._open_session,
            subprotocols=[Subprotocol(name) for name in protocol.SUBPROTOCOLS],
            max_size=FRAME_BYTES_MAX,
            ping_timeout=40,
        )
        self._numbered = dict(enumerate(self.services.values(), start=1))
        self._room = Room(ALL_BYTES)
        self._outgoing = Outgoing("uwsim-foxglove-write")
        self._offers = Offers(self, self._outgoing)
        self._offers.complete(shows_of(live, channels, self.feed, self._outgoing, self._offers.send, origin_m))
        self._greeting = self._greet()
        self._end_clock: Callable[[], None] = lambda: None
        self._parameters: ParameterTable | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        try:
            self._listener.start()
            self.start_updates()
            self._end_clock = self.feed.listen_time(TIME_S, self._send_time)
            if live is not None:
                self._parameters = ParameterTable(live)
                self._parameters.listen(lambda command, arguments: self._notice_parameters())
        except (OSError, RuntimeError):
            self.close()
            raise

    @property
    def port(self) -> int:
        """The port on which the server listens."""
        return self._listener.port

    @property
    def url(self) -> str:
        """The address to which clients connect, without the token."""
        return self._listener.url

    def close(self) -> bool:
        """Close all connections and stop the threads."""
        was_open = super().close()
        if was_open:
            self._end_clock()
            if self._parameters is not None:
                self._parameters.close()
            self._listener.stop()
            self._offers.close()
            self._outgoing.close()
        return was_open

    def take(self, reading: Reading) -> None:
        """Queue a reading on the simulator's thread."""
        self._offers.queue(reading)

    # Called by sessions:

    @property
    def command_topics(self) -> str:
        """The command topics to which the server subscribes, listed as text for messages to the user."""
        return f"/{', /'.join(self.inputs)}" if self.inputs else "none"

    def subscribe(self, session: Session, offer_id: int) -> None:
        """Start sending a topic's messages to a session. Raises ValueError if the topic is unknown."""
        self._offers.subscribe(offer_id, session.outbox, session.subscriptions[offer_id])

    def unsubscribe(self, session: Session, offer_id: int) -> None:
        """Stop sending a topic's messages to a session."""
        self._offers.unsubscribe(offer_id, session.outbox)

    def command(self, channel: Channel, encoding: str, data: bytes) -> None:
        """Apply a command. Raises ValueError or RuntimeError."""
        if encoding == "cdr":
            message = from_bytes(data, channel.type)
        else:
            message = from_plain(channel.type, protocol.read_json(data), most=MESSAGES_MAX)
        self.apply(channel, message)

    def relinquish(self, channel: Channel) -> None:
        """Notify a channel if sessions no longer advertise commands on it."""
        sessions = self._listener.sessions.values()
        named = [entry[0] for session in sessions for entry in session.advertised.values() if entry is not None]
        if all(one is not channel for one in named):
            self.abandon(channel)

    def is_vital(self, call: Call) -> bool:
        """Return whether a call is of a vital service, which other calls must not hinder."""
        service = self._numbered.get(call.service_id)
        return service is not None and service.is_vital

    def answer(self, call: Call, reply: Callable[[str | bytes], None]) -> None:
        """Call a service; `reply` is called later. Raises ValueError."""
        service = self._numbered.get(call.service_id)
        if service is None:
            raise ValueError(f"service {call.service_id}: does not exist")
        loop = asyncio.get_running_loop()

        def done(succeeded: bool, values: Any) -> None:
            frame = protocol.answer(call, values) if succeeded else protocol.call_failure(call, values)
            post(loop, reply, frame)

        self.call(service, protocol.read_json(call.data), done)

    @property
    def parameters(self) -> ParameterTable:
        """The simulator's parameters. Raises ValueError if there is only a recording."""
        if self._parameters is None:
            raise ValueError("parameters: there is no simulator, only a recording")
        return self._parameters

    def set_parameters(self, changes: Mapping[str, Any], done: Callable[[str | None], object]) -> None:
        """Set parameters; `done` is called later with the error, if any. Raises ValueError or NotRunningError."""
        loop = asyncio.get_running_loop()

        def finish(order: Future[Any]) -> None:
            error = None if order.cancelled() else order.exception()
            post(loop, done, None if error is None else str(error))

        self.parameters.set(changes).add_done_callback(finish)

    def _notice_parameters(self) -> None:
        """Have each session report changes, from the simulator's thread."""
        if self._loop is not None:
            post(self._loop, self._send_parameters)

    def _send_parameters(self) -> None:
        for session in list(self._listener.sessions.values()):
            session.send_parameters()

    # Setup of sessions:

    def _greet(self) -> list[str]:
        """Return the frames that open every conversation."""
        services = [(number, service.name, service.type) for number, service in self._numbered.items()]
        frames = [
            protocol.server_info("uwsim", str(time.time_ns() // 1_000_000), has_parameters=self.live is not None),
            protocol.advertisement(self._offers.offers),
        ]
        return [*frames, protocol.services_advertisement(services)] if services else frames

    def _open_session(
        self, connection: HeardConnection, wake: Callable[[], None], give_up: Callable[[str], None]
    ) -> Session:
        self._loop = asyncio.get_running_loop()
        session = Session(self, Outbox(self._room, wake, give_up))
        for frame in self._greeting:
            session.outbox.reply(frame)
        return session

    def _send_time(self, time_ns: int) -> None:
        """Send the time from the simulator's thread."""
        for session in list(self._listener.sessions.values()):
            session.outbox.send_time(time_ns)
