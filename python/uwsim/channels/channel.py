"""Channel and Service: the entries in a simulator's table of topics and services."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from uwsim.channels.taped import Taped
from uwsim.live import LiveSimulator, NotRunningError, Subscription
from uwsim.simulator.simulator import Simulator

COMMAND, PANEL, INSTRUMENT, PING, PICTURE = range(5)
"""Priorities on the acoustic link."""


def _no_message(sim: Simulator) -> Any:
    return None


def _no_command(live: LiveSimulator, message: Any) -> None:
    raise ValueError("it is not for commands")


class Drops:
    """Counts a channel's messages that were not delivered because a peer or the network was too slow."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self.count = 0

    def add(self) -> None:
        """Count one more, on any thread."""
        with self._lock:
            self.count += 1


@dataclass(frozen=True)
class Delivery:
    """How the messages of a channel that is read reach their readers.

    latched: whether later subscribers receive the latest message immediately. leads: whether the channel is read before
    the others at a tick, because their messages refer to its readings. is_sampled: whether a message that is the same
    object as the last one is the same sample, which is published once. on_request: whether the channel is sent and
    recorded only when requested by name, because its messages are large.

    late: whether, in real time, messages are published as soon as they are ready, and some are skipped, as with
    pictures. Their timing, but not their content, then depends on the machine. pieced: whether a late picture is
    assembled from earlier ones, so that its content also depends on the machine.

    follow: instead of a rate: calls a function with each message from now on, and returns what ends that.
    catch_up: for a channel whose messages build on each other, returns one message with everything since a cursor
    (None: since the beginning), and the next cursor. It may be called on any thread. update: called between two steps
    at rate_hz, even without subscribers, once a server offers the channel, because the content of its messages keeps
    growing; see `start_updates`.
    """

    latched: bool = False
    leads: bool = False
    is_sampled: bool = False
    on_request: bool = False
    late: bool = False
    pieced: bool = False
    catch_up: Callable[[Any], tuple[Any, Any]] | None = None
    follow: Callable[[Simulator, Callable[[Any], object]], Callable[[], None]] | None = None
    update: Callable[[Simulator], object] | None = None


LATCHED, LATE = Delivery(latched=True), Delivery(late=True)


@dataclass(frozen=True)
class OverLink:
    """How a channel crosses the acoustic link.

    priority: from COMMAND to PICTURE; the lowest number goes first. packing: how messages are packed into a few bytes,
    a key of uwsim.link.packing.PACKINGS, or "" for messages that no modem can carry.
    """

    priority: int = INSTRUMENT
    packing: str = "deflate"


class Door(Protocol):
    """Applies the messages of a vehicle's channels, subject to its helm: see `Steering`."""

    def apply(self, live: LiveSimulator, channel: Channel, message: Any, driver: str) -> None:
        """Apply a message that a client of this kind has published."""

    def left(self, live: LiveSimulator, channel: Channel) -> None:
        """Note that a channel has lost its last publisher."""


@dataclass(frozen=True)
class Authority:
    """Who may command through a channel, and what ends a command whose sender has fallen silent.

    door: for channels that command a vehicle, that through which bridges apply their messages. abandoned: called like
    `Channel.apply` when the last publisher has left. idle: the message that means "no command", which `abandoned`
    applies. A channel with such a message is also abandoned after some time without a command.
    """

    door: Door | None = None
    abandoned: Callable[[LiveSimulator], object] | None = None
    idle: Any = None


def ended_by(idle: Any, apply: Callable[[LiveSimulator, Any], object], door: Door | None = None) -> Authority:
    """Return the authority of a channel whose commands end when a message is applied."""
    return Authority(door, lambda live: apply(live, idle), idle)


@dataclass(frozen=True)
class Channel:
    """A topic.

    name: without a leading slash. type: in ROS 2's spelling, such as "sensor_msgs/msg/LaserScan". rate_hz: the rate of
    readings in simulated time, or None for a single reading when the first subscriber connects. over_link: None for
    channels that do not cross the acoustic link. drops: counted by the sinks and reported on /diagnostics.

    read: for direction "out", called between two steps on the simulator's thread. It returns a message of
    `ros.message_types.typestore()`, stamped with simulated time, or None if there is no message. taped: how many
    messages are made at once, the same as `read` would have returned; None if they must be read. apply: for direction
    "in", called on any thread. It must not block, and raises ValueError for impossible commands.
    """

    name: str
    type: str
    direction: Literal["out", "in"]
    description: str
    rate_hz: float | None = None
    frame_id: str = ""
    read: Callable[[Simulator], Any] = _no_message
    taped: Taped | None = None
    apply: Callable[[LiveSimulator, Any], object] = _no_command
    delivery: Delivery = Delivery()
    over_link: OverLink | None = None
    authority: Authority = Authority()
    drops: Drops = field(default_factory=Drops, compare=False, repr=False)


@dataclass(frozen=True)
class Service:
    """A service.

    call: receives the request as a dict of plain values and returns the response. It may wait for steps. If it raises
    ValueError, the message is sent to the caller. is_vital: whether a call must wait for no other call; `call` then
    returns at once, with a future of the response if that must wait. permit: for services that command a vehicle,
    called by bridges with the service's name and the request; raises ValueError for a caller without the right, see
    `Rights.require`.
    """

    name: str
    type: str
    call: Callable[[LiveSimulator, dict[str, Any]], dict[str, Any] | Future[dict[str, Any]]]
    description: str = ""
    is_vital: bool = False
    permit: Callable[[str, dict[str, Any]], object] | None = None


def require_live(live: LiveSimulator | None) -> LiveSimulator:
    """Return the simulator. Raises NotRunningError if there is none because a recording is being played."""
    if live is None:
        raise NotRunningError("there is no simulator, only a recording")
    return live


def start_updates(live: LiveSimulator | None, channels: Iterable[Channel]) -> list[Subscription]:
    """Start the work that channels do even without subscribers.

    Servers call this at startup, and cancel it on shutdown.
    """
    started: list[Subscription] = []
    if live is None:
        return started
    for channel in channels:
        if channel.delivery.update is not None and channel.rate_hz is not None:
            try:
                started.append(live.every(1.0 / channel.rate_hz, channel.delivery.update, _ignored))
            except NotRunningError:  # the simulator does not run
                break
    return started


def _ignored(result: object) -> None:
    pass
