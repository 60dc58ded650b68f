"""The order in which received messages are handled: stops, then sticks, then the rest, in turn for each peer."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.doors.waiting import Waiting

TERMINATE, ARM = 185, 400  # MAV_CMD
WHOLE_SYSTEM, AUTOPILOT = 0, 1  # target components
WAITING_MAX = 500  # messages of one peer; the largest mission has 1000 items, each of which is sent on request
STICKS_MAX = 10  # of one peer, the newest
COMMANDS = ("COMMAND_LONG", "COMMAND_INT")
STICKS = ("MANUAL_CONTROL", "RC_CHANNELS_OVERRIDE")
FLIGHT = {TERMINATE, ARM, 17, 21, 176, 192, 224, 300}
"""The commands that arm, release or steer the vehicle: a stop that overtakes them also ends them."""
FLIGHT_MESSAGES = (
    "SET_MODE", "SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT", "SET_ATTITUDE_TARGET",
    "MISSION_SET_CURRENT",
)  # fmt: skip

Received = tuple[Address, Any]


def is_stop(message: Any) -> bool:
    """Return whether a message sets all stop or disarms."""
    return (
        message.get_type() in COMMANDS
        and (message.command, message.param1) in ((TERMINATE, 1), (ARM, 0))
        and message.target_component in (WHOLE_SYSTEM, AUTOPILOT)
    )


def steers(message: Any) -> bool:
    """Return whether a message arms, releases or steers the vehicle."""
    kind = message.get_type()
    return kind in FLIGHT_MESSAGES or (kind in COMMANDS and message.command in FLIGHT)


class Backlog:
    """Messages that wait, in the order of arrival for each peer. Must be used on one thread.

    stop: called at once with each message that sets all stop; it is also queued, for its acknowledgement. drop: called
    with each message that is not handled: one that a stop has overtaken, which would undo it, and one too many of its
    peer.
    """

    def __init__(self, stop: Callable[[Any], object], drop: Callable[[Address, Any], object]) -> None:
        self._stop, self._drop = stop, drop
        self._stops: dict[tuple[int, Address], Any] = {}  # the same stop of the same peer is handled once
        self._sticks: dict[Address, Waiting[Any]] = {}
        self._waiting: dict[Address, Waiting[Any]] = {}  # the peer whose turn it is comes first

    def __bool__(self) -> bool:
        return bool(self._stops or self._sticks or self._waiting)

    def sort(self, received: Iterable[Received]) -> None:
        """Queue messages; set all stop at once."""
        for peer, message in received:
            if is_stop(message):
                self._end_what_steers()
                if message.command == TERMINATE:
                    self._stop(message)
                self._stops.setdefault((message.command, peer), message)
            elif message.get_type() in STICKS:
                self._sticks.setdefault(peer, Waiting(STICKS_MAX)).put(message)
            else:
                self._queue(peer, message)

    def take(self, *, only_urgent: bool = False) -> Received | None:
        """Remove and return the next message: a stop, or a stick message, or one of the peer whose turn it is."""
        if self._stops:
            key = min(self._stops)  # all stop before disarming
            return key[1], self._stops.pop(key)
        if self._sticks:
            return _next_in_turn(self._sticks)
        return _next_in_turn(self._waiting) if self._waiting and not only_urgent else None

    def _queue(self, peer: Address, message: Any) -> None:
        if not self._waiting.setdefault(peer, Waiting(WAITING_MAX)).offer(message):
            self._drop(peer, message)

    def _end_what_steers(self) -> None:
        for peer, waiting in list(self._waiting.items()):
            for message in waiting.taken():
                self._drop(peer, message) if steers(message) else waiting.offer(message)
            if not waiting:
                del self._waiting[peer]


def _next_in_turn(waiting: dict[Address, Waiting[Any]]) -> Received:
    """Remove and return the next message of the first peer, which is last in turn then."""
    peer = next(iter(waiting))
    messages = waiting.pop(peer)
    message = messages.take()
    if messages:
        waiting[peer] = messages
    return peer, message
