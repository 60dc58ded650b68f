"""A MAVLink component, such as an autopilot or a camera: it sends messages and executes commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.mavlink.endpoint import Wire

SYSTEM = 1
DONE, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4  # MAV_RESULT
REQUEST_MESSAGE, DO_SET_MODE = 512, 176  # MAV_CMD
SET_MODE = 11
"""The ID of the message, under which ArduPilot acknowledges it (GCS_Common.cpp, handle_set_mode), though no command."""
COUNTED_PEERS_MAX = 100

CRITICAL_TEXT, WARNING_TEXT, NOTICE_TEXT, INFO_TEXT = 2, 4, 5, 6  # MAV_SEVERITY


class SendText(Protocol):
    """Queues a text message for all ground stations. Without a severity, it is a warning."""

    def __call__(self, text: str, severity: int = WARNING_TEXT, /) -> None:
        """Queue a text."""


class Component:
    """One component of system 1. number: its ID. mav: encodes its messages.

    Messages to each peer are numbered separately, so that a gap in the numbers means a lost message. Must be used on
    one thread.
    """

    def __init__(self, dialect: Any, wire: Wire, number: int) -> None:
        self.number = number
        self.mav = dialect.MAVLink(None, srcSystem=SYSTEM, srcComponent=number)
        self._wire = wire
        self._sent: dict[Address, int] = {}

    def send(self, message: Any, peer: Address | None = None) -> None:
        """Send a message to one peer, or to all."""
        for each in self._wire.peers if peer is None else [peer]:
            self.mav.seq = self._sent.pop(each, 0)
            self._wire.send(bytes(message.pack(self.mav)), each)
            self._sent[each] = (self.mav.seq + 1) % 256
        while len(self._sent) > COUNTED_PEERS_MAX:
            del self._sent[next(iter(self._sent))]


class DeniedError(ValueError):
    """Raised for a command with an invalid parameter."""


@dataclass
class Given:
    """A command from a ground station.

    values: its seven parameters, any of which may be NaN or infinite; read them by the methods, which check them. A
    parameter that no part reads is reserved or has no effect here. sender: the sender's system and component. frame:
    the MAV_FRAME of a COMMAND_INT, whose fifth and sixth parameters are integers. replies: messages to send to the
    sender after the acknowledgement.
    """

    number: int
    values: tuple[float, ...]
    sender: tuple[int, int]
    frame: int | None = None
    replies: list[Any] = field(default_factory=list)

    def real(self, index: int, *, may_be_nan: bool = False) -> float:
        """Return the parameter with an index, from 1, which must be finite. Raises DeniedError.

        may_be_nan: whether NaN has a meaning, such as "unchanged".
        """
        value = self.values[index - 1]
        if not (math.isfinite(value) or (may_be_nan and math.isnan(value))):
            raise self.denied(index, "a number")
        return value

    def integer(self, index: int, low: float = -math.inf, high: float = math.inf) -> int:
        """Return the parameter with an index, from 1, which must be whole and in [low, high]. Raises DeniedError."""
        value = self.real(index)
        if not (value == math.floor(value) and low <= value <= high):
            raise self.denied(index, "whole" if math.isinf(low) else f"a whole number in [{low:g}, {high:g}]")
        return int(value)

    def switch(self, index: int) -> bool:
        """Return the parameter with an index, from 1, which must be exactly 0 (off) or 1 (on). Raises DeniedError."""
        if self.values[index - 1] not in (0, 1):
            raise self.denied(index, "0 or 1")
        return self.values[index - 1] == 1

    def denied(self, index: int, rule: str) -> DeniedError:
        """Return the error for a parameter, from 1, that breaks a rule."""
        return DeniedError(f"command {self.number}: param{index} = {self.values[index - 1]:g}: must be {rule}")


Obey = Callable[[Given], int]
"""Executes a command; returns a MAV_RESULT.

Checks all parameters before it changes anything: raises DeniedError for an invalid one. Raises ValueError or
RuntimeError with the reason for a failure.
"""
Answers = Callable[[int, float], Iterable[Any] | None]
"""Returns the messages for an ID and the second parameter of a request, or None for an unknown ID."""


class Commands:
    """Executes the commands that a component supports, and acknowledges each command.

    obeys: the commands, by MAV_CMD. answers: functions that provide the messages sent on request.
    """

    def __init__(
        self, component: Component, obeys: Mapping[int, Obey], answers: Iterable[Answers], send_text: SendText
    ) -> None:
        self._component, self._send_text = component, send_text
        self._answers = list(answers)
        self._obeys = {REQUEST_MESSAGE: self._request, **obeys}

    def knows(self, message: Any) -> bool:
        """Return whether a message is a supported command, or a request for a message that this component provides."""
        if message.get_type() not in ("COMMAND_LONG", "COMMAND_INT"):
            return False
        number = message.command
        if number != REQUEST_MESSAGE:
            return number in self._obeys
        wanted = message.param1
        return math.isfinite(wanted) and any(answer(int(wanted), 0.0) is not None for answer in self._answers)

    def on_command_long(self, peer: Address, message: Any) -> None:
        """Execute a command, and acknowledge it."""
        values = tuple(getattr(message, f"param{k}") for k in range(1, 8))
        self._obey(peer, Given(message.command, values, _sender(message)))

    def on_command_int(self, peer: Address, message: Any) -> None:
        """Execute a command whose fifth and sixth parameters are integers, and acknowledge it."""
        values = (*(getattr(message, f"param{k}") for k in range(1, 5)), message.x, message.y, message.z)
        self._obey(peer, Given(message.command, values, _sender(message), frame=message.frame))

    def on_set_mode(self, peer: Address, message: Any) -> None:
        """Change the mode as the command DO_SET_MODE, which succeeds this message, and acknowledge it."""
        values = (message.base_mode, message.custom_mode, *[0.0] * 5)
        self._obey(peer, Given(DO_SET_MODE, values, _sender(message)), SET_MODE)

    def _obey(self, peer: Address, given: Given, acknowledged: int | None = None) -> None:
        """Execute a command, and acknowledge it, by default under its own number."""
        obey = self._obeys.get(given.number)
        try:
            result = UNSUPPORTED if obey is None else obey(given)
        except (ValueError, RuntimeError) as error:
            self._send_text(str(error))
            result = DENIED if isinstance(error, DeniedError) else FAILED
        ack = self._component.mav.command_ack_encode(acknowledged or given.number, result, 0, 0, *given.sender)
        self._component.send(ack, peer)
        for message in given.replies:
            self._component.send(message, peer)

    def _request(self, given: Given) -> int:
        number = given.integer(1)
        for answer in self._answers:
            found = answer(number, given.real(2, may_be_nan=True))
            if found is not None:
                given.replies.extend(found)
                return DONE
        return UNSUPPORTED


def _sender(message: Any) -> tuple[int, int]:
    return message.get_srcSystem(), message.get_srcComponent()
