"""Commands in a recording, one JSON message each; merged where one argument takes many values, and frames joined."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from typing import Any, NamedTuple

from pydantic import NonNegativeInt, TypeAdapter, ValidationError

from uwsim.base.texts.json_text import json_object
from uwsim.base.texts.value_words import Detail, details, with_details, words
from uwsim.channels.ros import build
from uwsim.simulator.lockstep import FRAME_BYTES

COMMANDS = "uwsim/commands"
BYTES = "$bytes"


class Command(NamedTuple):
    """A command, and the tick at which it took effect or, for a jump in time, the tick after the jump.

    name: a command in uwsim.live.COMMANDS, reset or restore_state. arguments: JSON types and bytes.
    """

    tick: NonNegativeInt
    name: str
    arguments: dict[str, Any]


_COMMAND = TypeAdapter(Command)


def command_message(command: Command) -> Any:
    """Return a command as a std_msgs/String."""
    return build.text(json.dumps({**command._asdict(), "arguments": _json_values(command.arguments)}))


def command_of(message: Any) -> Command:
    """Decode the command in a message. Raises ValueError if the message contains none."""
    return command_from(message.data)


def command_from(text: str) -> Command:
    """Decode a command from JSON. Raises ValueError if the text contains none."""
    name = f"/{COMMANDS}: '{text:.60}'"
    try:
        command = _COMMAND.validate_python(json_object(text, name))
    except ValidationError as error:
        raise ValueError(f"{name}: {error.errors()[0]['msg']}") from None
    return command._replace(arguments=_from_json_values(command.arguments))


def _json_values(value: Any) -> Any:
    """Return plain values, with bytes encoded as base64."""
    if isinstance(value, bytes):
        return {BYTES: base64.b64encode(value).decode()}
    if isinstance(value, dict):
        return {key: _json_values(item) for key, item in value.items()}
    return [_json_values(item) for item in value] if isinstance(value, list) else value


def _from_json_values(value: Any) -> Any:
    if isinstance(value, dict):
        if set(value) == {BYTES} and isinstance(value[BYTES], str):
            return base64.b64decode(value[BYTES])
        return {key: _from_json_values(item) for key, item in value.items()}
    return [_from_json_values(item) for item in value] if isinstance(value, list) else value


ADDS = frozenset({"inject_fault", "note", "link_send"})
"""Commands of which each adds something, also the second of two equal ones."""


class CommandStream(NamedTuple):
    """Equal commands, except that one argument, a number, only grows or only falls, as when a head is turned.

    They are one event, since the first and the last value then describe all of them. key: that argument, or "" before
    its value has changed.
    """

    first: Command
    last: Command
    key: str = ""

    def with_next(self, command: Command) -> CommandStream | None:
        """Return the stream with another command, or None if that is an event of its own, such as any switch."""
        old, new = self.last.arguments, command.arguments
        if command.name != self.last.name or command.name in ADDS or old.keys() != new.keys():
            return None
        changed = [key for key in new if new[key] != old[key]]
        if not changed:
            may_repeat = any(map(_is_number, new.values())) and not any(isinstance(v, bool) for v in new.values())
            return self._replace(last=command) if may_repeat else None
        (key, *others) = changed
        if others or self.key not in ("", key) or not (_is_number(old[key]) and _is_number(new[key])):
            return None
        if self.key and (new[key] > old[key]) != (old[key] > self.first.arguments[key]):
            return None  # there and back is two events
        return self._replace(last=command, key=key)

    @property
    def text(self) -> str:
        """The command with its vehicle and details."""
        return with_details(f"{words(self.last.name)} {self.vehicle}".strip(), self.details)

    @property
    def vehicle(self) -> str:
        """The vehicle that it commands, or ""."""
        return str(self.last.arguments.get("vehicle") or "")

    @property
    def details(self) -> list[Detail]:
        """The arguments in words: of the one that changes, the first and the last value."""
        given = {key: value for key, value in self.first.arguments.items() if key != "vehicle"}
        return details(given, self.last.arguments)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


PIECE_TICKS = 400
"""A piece ends at a multiple of this many ticks at the latest."""


class JoinedFrames:
    """The frames that wait, by vehicle: the arguments of the command `servo_frames`."""

    def __init__(self) -> None:
        self._waiting: dict[str, dict[str, Any]] = {}

    def add(self, arguments: dict[str, Any]) -> Iterator[dict[str, Any]]:
        """Add the arguments of a command, and yield those of all pieces that are complete."""
        waiting = self._waiting.pop(arguments["vehicle"], None)
        if waiting is not None and arguments == {
            **waiting, "from_tick": end_tick(waiting), "frames": arguments["frames"]
        }:  # fmt: skip
            arguments = {**waiting, "frames": waiting["frames"] + arguments["frames"]}
        elif waiting is not None:
            yield waiting
        while (count := PIECE_TICKS - int(arguments["from_tick"]) % PIECE_TICKS) <= _count(arguments):
            frames, at = arguments["frames"], count * FRAME_BYTES
            yield {**arguments, "frames": frames[:at]}
            arguments = {**arguments, "from_tick": arguments["from_tick"] + count, "frames": frames[at:]}
        if arguments["frames"]:
            self._waiting[arguments["vehicle"]] = arguments

    def taken(self) -> Iterator[dict[str, Any]]:
        """Yield what waits, if anything, which then waits no longer."""
        waiting, self._waiting = self._waiting, {}
        yield from waiting.values()


def end_tick(arguments: dict[str, Any]) -> int:
    """Return the tick at which the last of the frames has been made."""
    return int(arguments["from_tick"]) + _count(arguments)


def _count(arguments: dict[str, Any]) -> int:
    return len(arguments["frames"]) // FRAME_BYTES
