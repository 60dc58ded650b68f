"""The simulator's parameters under the names of at most 16 characters that MAVLink's parameter protocol allows."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.settings import Settings
from uwsim.bridges.mavlink.stations import sender_of

ID_CHARACTERS = 16
AT_ONCE = 20
INT32, REAL32 = 6, 9  # MAV_PARAM_TYPE
DOES_NOT_EXIST = 1  # MAV_PARAM_ERROR

OWN_NAMES = {"WPNAV_RADIUS": ("xy_goal_tolerance", 100.0)}
"""ArduSub's names of the vehicle's parameters, each with the factor to its unit: [cm]."""

Send = Callable[..., None]
"""Sends a message to a peer, or to all."""
DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def ids_of(values: Mapping[str, Any], vehicles: Iterable[str]) -> dict[str, str]:
    """Return the names of all parameters that are numbers or flags, by MAVLink ID.

    An ID is the name without its vehicle, in capitals. If that is too long or already taken, the ID consists of the end
    of the name and the number of the parameter in base 36.
    """
    numeric = [name for name, value in values.items() if isinstance(value, bool | int | float)]
    own = tuple(f"{vehicle}." for vehicle in vehicles)[:1]
    found: dict[str, str] = {}
    for index, name in enumerate(numeric):
        plain = re.sub(r"\W", "_", name.removeprefix(own[0]) if own else name).upper()
        if len(plain) > ID_CHARACTERS or plain in found:
            number = DIGITS[index // 36 // 36 % 36] + DIGITS[index // 36 % 36] + DIGITS[index % 36]
            plain = f"{plain[-ID_CHARACTERS + 4 :].lstrip('_')}_{number}"
        found[plain] = name
    return found


def as_value(number: float, present: Any) -> Any:
    """Convert a received number to the type of the parameter's present value. Raises ValueError if that rounds it."""
    if not math.isfinite(number):
        raise ValueError("must be a number")
    if isinstance(present, bool):
        if number not in (0, 1):
            raise ValueError("must be 0 or 1")
        return number == 1
    if isinstance(present, int):
        if number != math.floor(number):
            raise ValueError("must be a whole number")
        return int(number)
    return float(number)


class ParameterServer:
    """Lists, reads and sets parameters for ground stations. ids: names by ID.

    settings: further parameters, those of the bridge itself. Must be used on one thread.
    """

    def __init__(self, craft: Craft, mav: Any, send: Send, settings: Settings) -> None:
        live = craft.live
        self._craft, self._live, self._mav, self._send, self._settings = craft, live, mav, send, settings
        own = {name: f"{craft.name}.{plain}" for name, (plain, _) in OWN_NAMES.items()}
        self.ids = ids_of(live.simulator.parameters, live.vehicles) | {name: name for name in settings} | own
        self._indices = {name: index for index, name in enumerate(self.ids)}
        self._due: deque[tuple[Address, str]] = deque()

    def send_some(self) -> None:
        """Send the next few parameters of the lists that peers have requested."""
        for _ in range(min(AT_ONCE, len(self._due))):
            peer, name = self._due.popleft()
            self._send(self._value(name), peer)

    def _present(self, name: str) -> Any:
        if name in self._settings:
            return self._settings[name]
        value = self._live.simulator.parameters[self.ids[name]]
        return value * OWN_NAMES[name][1] if name in OWN_NAMES else value

    def _value(self, name: str) -> Any:
        value = self._present(name)
        kind = INT32 if isinstance(value, int) else REAL32
        return self._mav.param_value_encode(name.encode(), float(value), kind, len(self.ids), self._indices[name])

    def on_param_request_list(self, peer: Address, message: Any) -> None:
        """Send all parameters, a few at a time."""
        others = ((whose, name) for whose, name in self._due if whose != peer)
        self._due = deque([*others, *((peer, name) for name in self.ids)])

    def on_param_request_read(self, peer: Address, message: Any) -> None:
        """Send one parameter, selected by ID or by index."""
        index = message.param_index
        name = message.param_id if index < 0 else next(iter(list(self.ids)[index : index + 1]), "")
        if name in self.ids:
            self._send(self._value(name), peer)
        else:
            self._send_unknown(peer, message, name, index)

    def _send_unknown(self, peer: Address, message: Any, name: str, index: int = -1) -> None:
        """Send PARAM_ERROR, as ArduPilot does since 4.7 (GCS_Param.cpp, send_param_error); clients stop to wait."""
        sender = sender_of(message)
        self._send(self._mav.param_error_encode(*sender, name.encode(), index, DOES_NOT_EXIST), peer)

    def on_param_set(self, peer: Address, message: Any) -> None:
        """Set a parameter, and send its value: the old value if the new one is refused. Raises ValueError."""
        name = message.param_id
        if name not in self.ids:
            self._send_unknown(peer, message, name)
            raise ValueError(f"parameter '{name}': unknown")
        try:
            value = as_value(message.param_value, self._present(name))
        except ValueError as error:
            self._send(self._value(name))
            raise ValueError(f"parameter '{name}' = {message.param_value:g}: {error}") from None
        try:
            if name in self._settings:
                self._settings.set(name, value)
            else:
                if name in OWN_NAMES:
                    value /= OWN_NAMES[name][1]
                order = self._live.command("set_parameter", name=self.ids[name], value=value)
                self._craft.wait(order, f"parameter '{name}'")
        finally:
            self._send(self._value(name))
