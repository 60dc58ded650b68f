"""The parameters that clients access through rosapi: the simulator's, and a store like ROS's parameter server."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parse import parse_value
from uwsim.live import LiveSimulator
from uwsim.simulator.parameters import Parameters as SimulatorParameters

MOST = 10_000
LONGEST = 100_000  # maximum length of a value in JSON
VALUE_LIMITS = Limits(frame_bytes=LONGEST)
MOST_BYTES = 16 << 20  # total of all names and values


class Parameters:
    """JSON values, keyed by name.

    Setting a simulator parameter, such as rov/drag/linear/surge, takes effect. Others are merely stored for clients.
    present: the initial content of the store, such as use_sim_time. live: returns the current simulator.
    described: returns the vehicles' URDFs by name, which clients read unless they have stored others.
    """

    def __init__(
        self,
        present: Mapping[str, str],
        live: Callable[[], LiveSimulator | None] = lambda: None,
        described: Callable[[], Mapping[str, str]] = dict,
    ) -> None:
        self._values = dict(present)
        self._bytes = sum(_size(name, text) for name, text in present.items())
        self._live = live
        self._described = described

    def names(self) -> list[str]:
        """Return all names, sorted."""
        own = self._simulators()
        return sorted([*{**self._described(), **self._values}, *(name.replace(".", "/") for name in own or ())])

    def _simulators(self) -> SimulatorParameters | None:
        live = self._live()
        return None if live is None else live.simulator.parameters

    def _in_simulator(self, name: str) -> bool:
        own = self._simulators()
        return own is not None and name.replace("/", ".") in own

    def has(self, name: str) -> bool:
        """Return whether a parameter has a value."""
        return name in self._values or name in self._described() or self._in_simulator(name)

    def get_json(self, name: str, default: str = "null") -> str:
        """Return a parameter's value as JSON or, for a prefix of simulator names, an object of all values below it."""
        own = self._simulators()
        if own is not None and self._in_simulator(name):
            return json.dumps(own[name.replace("/", ".")])
        if name in self._values:
            return self._values[name]
        described = self._described()
        return json.dumps(described[name]) if name in described else default

    def set_json(self, name: str, text: Any) -> Future[Any] | None:
        """Set a parameter from JSON.

        Raises ValueError without changing anything. For simulator parameters, returns a future that may raise it.
        """
        if not isinstance(text, str) or len(text) > LONGEST:
            raise ValueError(f"parameter '{name}': the value must be JSON as a string of {LONGEST} characters at most")
        try:
            value = parse_value(text, VALUE_LIMITS)
        except ValueError as error:
            raise ValueError(f"parameter '{name}': {error}") from None
        live = self._live()
        if live is not None and self._in_simulator(name):
            return live.command("set_parameter", name=name.replace("/", "."), value=value)
        if name not in self._values and len(self._values) >= MOST:
            raise ValueError(f"parameter '{name}': there are {MOST}, the maximum")
        grown = self._bytes + _size(name, text) - (_size(name, self._values[name]) if name in self._values else 0)
        if grown > MOST_BYTES:
            raise ValueError(f"parameter '{name}': all would have {grown} bytes: must be {MOST_BYTES} at most")
        self._values[name], self._bytes = text, grown
        return None

    def delete(self, name: str) -> None:
        """Remove a parameter from the store. Raises ValueError if it is not in the store."""
        if self._in_simulator(name):
            raise ValueError(f"parameter '{name}': belongs to the simulator: reset it with simulation/reset_parameters")
        text = self._values.pop(name, None)
        if text is None:
            raise ValueError(f"parameter '{name}': no parameter has this name")
        self._bytes -= _size(name, text)


def _size(name: str, text: str) -> int:
    """Return the memory [bytes] occupied by a value and its name."""
    return sys.getsizeof(name) + sys.getsizeof(text)
