"""FoxgloveServer: the Foxglove app, or any client of its WebSocket protocol, sees and steers a live simulator."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Sequence
from ipaddress import ip_address
from types import TracebackType
from typing import Any, Self

import foxglove
import orjson
from foxglove import Schema, StatusLevel
from foxglove.websocket import Capability, ChannelView, Client, ClientChannel, MessageSchema, Service, ServiceSchema

from uwsim.bridges.foxglove.shows import shows_of
from uwsim.channels import Channel, keep_up, require_live
from uwsim.channels import Service as ChannelService
from uwsim.channels.cdr import schema
from uwsim.channels.feed import Feed, Reading, Readings
from uwsim.channels.messages import from_bytes, from_plain
from uwsim.channels.outgoing import Line, Outgoing, queue_of
from uwsim.live import LiveSimulator

PORT = 8765  # the app's default
BACKLOG = 64  # messages that wait for a slow client; then the oldest give way
TIME_S = 0.05  # simulated, between two tellings of the time
MESSAGE_BYTES_MAX = 1 << 20

logger = logging.getLogger("uwsim.foxglove")


class FoxgloveServer:
    """A Foxglove WebSocket server on threads of its own.

        with LiveSimulator("lake") as live, FoxgloveServer(live, channels(live.simulator)):
            ...

    Topics carry CDR with ROS 2's schemas, so that panels treat them as a robot's; /scene/* are for the 3D panel.
    Clients may publish on the topics that the simulator hears, in CDR or JSON, and call its services in JSON. A topic
    is read while somebody subscribes to it. feed: shared with other sinks. live: None with the feed of a recording,
    which hears nothing, and of whose scenes only the maps are there. port 0 chooses one, see `port`. Raises OSError if
    it cannot listen, and warns (UserWarning) when others than this machine can connect.
    """

    def __init__(
        self,
        live: LiveSimulator | None,
        channels: Sequence[Channel],
        services: Sequence[ChannelService] = (),
        *,
        host: str = "127.0.0.1",
        port: int = PORT,
        feed: Readings | None = None,
    ) -> None:
        if not 0 <= port <= 65535:
            raise ValueError(f"port = {port}: must be in [0, 65535]")
        _warn_beyond_loopback(host)
        self._live = live
        self._feed = feed or Feed(require_live(live))
        self._outgoing = Outgoing("uwsim-foxglove")
        self._ends: dict[str, Callable[[], None]] = {}
        self._subscribers: dict[str, set[int]] = {}
        self._inputs = {channel.name: channel for channel in channels if channel.direction == "in"}
        self._outputs = {channel.name: channel for channel in channels if channel.direction == "out"}
        self._heard: dict[tuple[int, int], tuple[Channel, str]] = {}
        self._context = context = foxglove.Context()  # kept here: the SDK keeps it for nobody
        self._logs = {channel.name: _log_of(channel, context) for channel in self._outputs.values()}
        self._lines = {channel.name: Line(channel.name, queue_of(channel.type)) for channel in self._outputs.values()}
        self._status = Line("status", 10)
        self._shows = {show.topic: show for show in shows_of(live, channels, self._feed, self._outgoing, context)}
        try:
            self._server = foxglove.start_server(
                name="uwsim",
                host=host,
                port=port,
                context=context,
                capabilities=[Capability.ClientPublish, Capability.Services, Capability.Time],
                supported_encodings=["cdr", "json"],
                services=[self._service(service) for service in services],
                server_listener=self,
                message_backlog_size=BACKLOG,
            )
        except Exception as error:  # the SDK's own
            self._outgoing.close()
            raise OSError(f"cannot listen on {host}:{port}: {error}") from None
        self._host = host
        self._going_on = keep_up(live, channels)
        self._end_clock = self._feed.tell_time(TIME_S, self._server.broadcast_time)

    @property
    def port(self) -> int:
        """Where it listens."""
        return self._server.port

    @property
    def url(self) -> str:
        """The address that clients connect to."""
        return f"ws://[{self._host}]:{self.port}" if ":" in self._host else f"ws://{self._host}:{self.port}"

    def close(self) -> None:
        """Close all connections and end the threads."""
        self._end_clock()
        for subscription in self._going_on:
            subscription.cancel()
        for name in list(self._ends):
            self._ends.pop(name)()
        for show in self._shows.values():
            show.end()
        self._server.stop()
        self._outgoing.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    # What the SDK calls, on threads of its own:

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Begin to read a topic; whoever comes later to a latched one gets its newest message."""
        name = channel.topic.lstrip("/")
        others = self._subscribers.setdefault(name, set())
        is_first = not others
        others.add(client.id)
        if name in self._shows:
            self._shows[name].begin()
        elif is_first:
            self._ends[name] = self._feed.listen(self._outputs[name], self._send)
        elif self._outputs[name].latched and (newest := self._feed.newest(self._outputs[name])):
            self._send(newest)

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """End to read a topic that nobody wants."""
        name = channel.topic.lstrip("/")
        others = self._subscribers.get(name, set())
        others.discard(client.id)
        if others:
            return
        if name in self._shows:
            self._shows[name].end()
        elif name in self._ends:
            self._ends.pop(name)()

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        """Take note of what a client wants to publish."""
        name = channel.topic.lstrip("/")
        target = self._inputs.get(name)
        if target is None:
            self._warn(f"topic '{channel.topic}': the simulator does not hear it; it hears /{', /'.join(self._inputs)}")
        elif channel.encoding not in ("cdr", "json"):
            self._warn(f"topic '{channel.topic}': encoding '{channel.encoding}': must be cdr or json")
        elif _full(channel.schema_name) != target.type:
            self._warn(f"topic '{channel.topic}' is {target.type}, not {channel.schema_name}")
        else:
            self._heard[client.id, channel.id] = target, channel.encoding

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        """Forget it."""
        self._heard.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        """Apply a client's message."""
        found = self._heard.get((client.id, client_channel_id))
        if found is None:
            return  # what is wrong with it was said when it was advertised
        channel, encoding = found
        try:
            if len(data) > MESSAGE_BYTES_MAX:
                raise ValueError(f"{len(data)} bytes: must be {MESSAGE_BYTES_MAX} at most")
            message = from_bytes(data, channel.type) if encoding == "cdr" else from_plain(channel.type, _json(data))
            channel.apply(require_live(self._live), message)
        except (ValueError, RuntimeError) as error:
            self._warn(f"/{channel.name}: {error}")

    def __getattr__(self, name: str) -> Any:
        """Ignore what else the SDK may call."""
        if name.startswith("on_"):
            return lambda *_: None
        raise AttributeError(name)

    def _send(self, reading: Reading) -> None:
        """Queue a reading, on the simulator's thread."""
        name = reading.channel.name

        def write() -> bool:
            self._logs[name].log(bytes(reading.cdr), log_time=reading.time_ns)
            return True

        self._outgoing.offer(self._lines[name], write)

    def _warn(self, text: str) -> None:
        logger.warning("%s", text)

        def tell() -> bool:
            self._server.publish_status(text, StatusLevel.Warning)
            return True

        self._outgoing.offer(self._status, tell)  # to call it here, on the SDK's thread, might deadlock

    def _service(self, service: ChannelService) -> Service:
        def call(request: Any) -> bytes:
            """Answer; an error's text goes to the caller."""
            return orjson.dumps(service.call(require_live(self._live), _json(request.payload)), default=str)

        anything = MessageSchema(
            encoding="json", schema=Schema(name=service.type, encoding="jsonschema", data=b'{"type":"object"}')
        )
        return Service(
            f"/{service.name}",
            schema=ServiceSchema(service.type, request=anything, response=anything),
            handler=call,
        )


def _log_of(channel: Channel, context: foxglove.Context) -> foxglove.Channel:
    found = schema(channel.type)
    return foxglove.Channel(
        f"/{channel.name}",
        message_encoding="cdr",
        schema=Schema(name=channel.type, encoding="ros2msg", data=found.text.encode()),
        context=context,
        metadata={"type_hash": found.type_hash, "description": channel.description},
    )


def _full(name: str) -> str:
    """Return a type's name in ROS 2's spelling."""
    return name if "/msg/" in name else name.replace("/", "/msg/", 1)


def _json(data: bytes) -> Any:
    try:
        found = orjson.loads(data or b"{}")
    except ValueError as error:
        raise ValueError(f"{data[:60]!r}: must be JSON ({error})") from None
    if not isinstance(found, dict):
        raise ValueError(f"{data[:60]!r}: must be an object in JSON")
    return found


def _warn_beyond_loopback(host: str) -> None:
    try:
        is_local = host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        is_local = False
    if not is_local:
        warnings.warn(f"{host}: everybody who can reach this address can steer the simulator", stacklevel=3)
