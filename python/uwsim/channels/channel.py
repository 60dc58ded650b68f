"""Channel and Service: the entries in a simulator's table of topics and services."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from uwsim.live import LiveSimulator, NotRunningError, Subscription
from uwsim.simulator.simulator import Simulator

if TYPE_CHECKING:
    from uwsim.channels.rights import Rights
    from uwsim.channels.watchdog import Watchdog

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
class Channel:
    """A topic.

    name: without a leading slash. type: in ROS 2's spelling, such as "sensor_msgs/msg/LaserScan". rate_hz: the rate of
    readings in simulated time, or None for a single reading when the first subscriber connects. latched: whether later
    subscribers receive the latest message immediately. leads: whether the channel is read before the others at a tick,
    because their messages refer to its readings. over_link: whether the channel crosses the acoustic link. priority:
    the priority on the link, from COMMAND to PICTURE; the lowest number goes first. packing: how messages are packed
    into a few bytes for the link, a key of uwsim.link.packing.PACKINGS, or "" for messages that no modem can carry.

    late: whether, in real time, messages are published as soon as they are ready, and some are skipped, as with
    pictures. Their timing, but not their content, then depends on the machine. pieced: whether a late picture is
    assembled from earlier ones, so that its content also depends on the machine. on_request: whether the channel is
    sent and recorded only when requested by name, because its messages are large.

    catch_up: for a channel whose messages build on each other, returns one message with everything since a cursor
    (None: since the beginning), and the next cursor. It may be called on any thread. keep_up: called between two steps
    at rate_hz, even without subscribers, once a server offers the channel, because the content of its messages keeps
    growing; see `keep_up`.

    read: for direction "out", called between two steps on the simulator's thread. It returns a message of
    `messages.typestore()`, stamped with simulated time, or None if there is no message. apply: for direction "in",
    called on any thread. It must not block, and raises ValueError for impossible commands. abandoned: for direction
    "in", called like `apply` when the last publisher has left. idle: for direction "in", the message that means "no
    command", which `abandoned` applies. A channel with such a message is also abandoned after some time without a
    command.

    watch: the vehicle's watchdog, for channels that steer. rights: for channels that command a vehicle, determines
    which commands the bridges apply. drops: counted by the sinks and reported on /diagnostics.
    """

    name: str
    type: str
    direction: Literal["out", "in"]
    description: str
    rate_hz: float | None = None
    latched: bool = False
    leads: bool = False
    frame_id: str = ""
    over_link: bool = False
    priority: int = INSTRUMENT
    packing: str = "deflate"
    catch_up: Callable[[Any], tuple[Any, Any]] | None = None
    late: bool = False
    pieced: bool = False
    on_request: bool = False
    keep_up: Callable[[Simulator], object] | None = None
    read: Callable[[Simulator], Any] = _no_message
    apply: Callable[[LiveSimulator, Any], object] = _no_command
    abandoned: Callable[[LiveSimulator], object] | None = None
    idle: Any = None
    watch: Watchdog | None = None
    rights: Rights | None = None
    drops: Drops = field(default_factory=Drops, compare=False, repr=False)

    @property
    def has_timeout(self) -> bool:
        """Whether the channel's command expires if no further command arrives within the timeout."""
        return self.idle is not None


@dataclass(frozen=True)
class Service:
    """A service.

    call: receives the request as a dict of plain values and returns the response. It may wait for steps. If it raises
    ValueError, the message is sent to the caller. is_vital: whether a call must not wait for calls of other services.
    rights: for services that command a vehicle, determines which calls the bridges accept.
    """

    name: str
    type: str
    call: Callable[[LiveSimulator, dict[str, Any]], dict[str, Any]]
    description: str = ""
    is_vital: bool = False
    rights: Rights | None = None


def require_live(live: LiveSimulator | None) -> LiveSimulator:
    """Return the simulator. Raises NotRunningError if there is none because a recording is being played."""
    if live is None:
        raise NotRunningError("there is no simulator, only a recording")
    return live


def keep_up(live: LiveSimulator | None, channels: Iterable[Channel]) -> list[Subscription]:
    """Start the work that channels do even without subscribers.

    Servers call this at startup, and cancel it on shutdown.
    """
    going_on: list[Subscription] = []
    if live is None:
        return going_on
    for channel in channels:
        if channel.keep_up is not None and channel.rate_hz is not None:
            try:
                going_on.append(live.every(1.0 / channel.rate_hz, channel.keep_up, _ignored))
            except NotRunningError:  # the simulator does not run
                return going_on
    return going_on


def _ignored(result: object) -> None:
    pass
