"""Commands in a recording, each one JSON message on a separate topic."""

from __future__ import annotations

import base64
import json
from typing import Any, NamedTuple

from pydantic import NonNegativeInt, TypeAdapter, ValidationError

from uwsim.base.texts.json_text import json_object
from uwsim.channels.ros import build

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
