"""The simulator as seen from the station. Commands to vehicles go over the link; others are applied directly."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from uwsim.base.arguments import plain
from uwsim.base.commands import COMMANDS, bound_command
from uwsim.base.texts.json_text import json_object
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

TOPIC = "command/"


class RemoteSimulator:
    """A LiveSimulator whose commands to vehicles are sent over the link.

    The futures of these commands resolve when the commands are queued, since the station cannot know when they arrive.
    has_sent: whether any command has gone over the link. A vehicle on deck has its commands from there; see
    `is_on_deck`.
    """

    def __init__(self, live: LiveSimulator, send: Callable[[str, str, dict[str, Any]], Future[Any]]) -> None:
        self._live = live
        self._send = send
        self.has_sent = False

    def __getattr__(self, name: str) -> Any:
        """Return any other attribute of the simulator."""
        return getattr(self._live, name)

    def command(self, name: str, /, **arguments: Any) -> Future[Any]:
        """Send a command to a vehicle, or apply it directly if it is for the simulator.

        Raises ValueError if it is invalid.
        """
        vehicle = arguments.get("vehicle")
        if vehicle is None or not crosses_link(name) or is_on_deck(self._live.simulator, vehicle):
            return self._live.command(name, **arguments)
        kept = {key: plain(value, f"command '{name}': {key}") for key, value in arguments.items()}
        bound_command(name, kept)
        del kept["vehicle"]
        self.has_sent = True
        return self._send(name, vehicle, kept)


def is_on_deck(sim: Simulator, vehicle: str) -> bool:
    """Return whether a vehicle hangs in a dock above the water, where no modem is heard: it takes commands there."""
    one = sim.vehicles.get(vehicle)
    if sim.link is None or sim.link.modem.kind != "modem" or one is None or one.released:
        return False
    return float(one.pose.position_world_m[2]) > 0.0


def crosses_link(name: str) -> bool:
    """Return whether a command goes to a vehicle rather than, like `place`, to the simulator."""
    return name in COMMANDS and COMMANDS[name].crosses_link


def packed(name: str, arguments: dict[str, Any]) -> tuple[str, bytes]:
    """Return a command's topic, which includes its name, and its arguments as JSON, deflated if that is shorter."""
    text = json.dumps(_rounded(arguments), separators=(",", ":")).encode() if arguments else b""
    deflated = zlib.compress(text, 9)
    return TOPIC + name, b"\x01" + deflated if len(deflated) < len(text) else b"\x00" + text


def unpacked(topic: str, payload: bytes) -> tuple[str, dict[str, Any]]:
    """Return a command's name and its arguments."""
    text = zlib.decompress(payload[1:]) if payload[:1] == b"\x01" else payload[1:]
    return topic.removeprefix(TOPIC), json_object(text, topic) if text else {}


def _rounded(value: Any) -> Any:
    """Return plain values rounded to five significant digits, to save a modem's capacity."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    return [_rounded(item) for item in value] if isinstance(value, list) else value
