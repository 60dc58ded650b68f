"""A MAVLink component, such as an autopilot or a camera: what it sends, and the commands that it obeys."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from uwsim.bridges.mavlink.endpoint import Peer, Wire

SYSTEM = 1
DONE, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4  # MAV_RESULT
REQUEST_MESSAGE = 512  # MAV_CMD
COUNTED_PEERS_MAX = 100

Say = Callable[[str], None]
"""Sends a text to all ground stations, and logs it."""


class Component:
    """One component of system 1. number: its id. mav: encodes its messages. For one thread.

    Messages are numbered for each peer, so that a gap in the numbers means a lost message.
    """

    def __init__(self, dialect: Any, wire: Wire, number: int) -> None:
        self.number = number
        self.mav = dialect.MAVLink(None, srcSystem=SYSTEM, srcComponent=number)
        self._wire = wire
        self._sent: dict[Peer, int] = {}

    def send(self, message: Any, peer: Peer | None = None) -> None:
        """Send a message to one peer, or to all."""
        for each in self._wire.peers if peer is None else [peer]:
            self.mav.seq = self._sent.pop(each, 0)
            self._wire.send(bytes(message.pack(self.mav)), each)
            self._sent[each] = (self.mav.seq + 1) % 256
        while len(self._sent) > COUNTED_PEERS_MAX:
            del self._sent[next(iter(self._sent))]


@dataclass
class Given:
    """A command that a ground station has sent.

    values: its seven parameters; of a COMMAND_INT, the fifth and sixth are integers, with a frame (MAV_FRAME). sender:
    its system and component. replies: messages for the sender, after the acknowledgement.
    """

    number: int
    values: tuple[float, ...]
    sender: tuple[int, int]
    frame: int | None = None
    replies: list[Any] = field(default_factory=list)

    def integer(self, index: int) -> int:
        """Return a parameter, counted from 1, as an integer. Raises ValueError if it is no number."""
        value = self.values[index - 1]
        if not math.isfinite(value):
            raise ValueError(f"command {self.number}: param{index} = {value}: must be a number")
        return int(value)


Obey = Callable[[Given], int]
"""Obeys a command; returns a MAV_RESULT. Raises ValueError or RuntimeError with the reason of a failure."""
Answers = Callable[[int, float], Iterable[Any] | None]
"""Returns the messages with an id, for the second parameter of a request; None for an unknown id."""


class Commands:
    """Obeys the commands that a component knows, by their numbers (MAV_CMD), and acknowledges each.

    answers: the messages that it sends on request.
    """

    def __init__(self, component: Component, obeys: Mapping[int, Obey], answers: Iterable[Answers], say: Say) -> None:
        self._component, self._say = component, say
        self._answers = list(answers)
        self._obeys = {REQUEST_MESSAGE: self._request, **obeys}

    def knows(self, message: Any) -> bool:
        """Return whether a message is a command that this component obeys, or a request for a message that it has."""
        if message.get_type() not in ("COMMAND_LONG", "COMMAND_INT"):
            return False
        number = message.command
        if number != REQUEST_MESSAGE:
            return number in self._obeys
        wanted = message.param1
        return math.isfinite(wanted) and any(answer(int(wanted), 0.0) is not None for answer in self._answers)

    def on_command_long(self, peer: Peer, message: Any) -> None:
        """Obey a command, and acknowledge it."""
        values = tuple(getattr(message, f"param{k}") for k in range(1, 8))
        self._obey(peer, Given(message.command, values, _sender(message)))

    def on_command_int(self, peer: Peer, message: Any) -> None:
        """Obey a command whose fifth and sixth parameters are integers, and acknowledge it."""
        values = (*(getattr(message, f"param{k}") for k in range(1, 5)), message.x, message.y, message.z)
        self._obey(peer, Given(message.command, values, _sender(message), frame=message.frame))

    def _obey(self, peer: Peer, given: Given) -> None:
        obey = self._obeys.get(given.number)
        try:
            result = UNSUPPORTED if obey is None else obey(given)
        except (ValueError, RuntimeError) as error:
            self._say(str(error))
            result = FAILED
        ack = self._component.mav.command_ack_encode(given.number, result, 0, 0, *given.sender)
        self._component.send(ack, peer)
        for message in given.replies:
            self._component.send(message, peer)

    def _request(self, given: Given) -> int:
        number = given.integer(1)
        for answer in self._answers:
            found = answer(number, given.values[1])
            if found is not None:
                given.replies.extend(found)
                return DONE
        return UNSUPPORTED


def _sender(message: Any) -> tuple[int, int]:
    return message.get_srcSystem(), message.get_srcComponent()
