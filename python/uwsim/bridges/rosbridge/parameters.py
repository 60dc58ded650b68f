"""The parameters that clients access through rosapi: the simulator's, and a store like ROS's parameter server."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parse import parse_value
from uwsim.channels.calls.parameter_table import ParameterTable
from uwsim.live import LiveSimulator

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
        own = () if (table := self._table()) is None else table.own
        return sorted([*{**self._described(), **self._values}, *(name.replace(".", "/") for name in own)])

    def _table(self) -> ParameterTable | None:
        live = self._live()
        return None if live is None else ParameterTable(live)

    def _simulators(self, name: str) -> tuple[ParameterTable, str] | None:
        """Return the table and its name of a simulator's parameter, or of a prefix of some; None for any other name."""
        table, dotted = self._table(), name.replace("/", ".")
        return None if table is None or dotted not in table.own else (table, dotted)

    def has(self, name: str) -> bool:
        """Return whether a parameter has a value."""
        return name in self._values or name in self._described() or self._simulators(name) is not None

    def get_json(self, name: str, default: str = "null") -> str:
        """Return a parameter's value as JSON or, for a prefix of simulator names, an object of all values below it."""
        if (found := self._simulators(name)) is not None:
            return json.dumps(found[0].own[found[1]])
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
        if (found := self._simulators(name)) is not None:
            return found[0].set({found[1]: value})
        if name not in self._values and len(self._values) >= MOST:
            raise ValueError(f"parameter '{name}': there are {MOST}, the maximum")
        grown = self._bytes + _size(name, text) - (_size(name, self._values[name]) if name in self._values else 0)
        if grown > MOST_BYTES:
            raise ValueError(f"parameter '{name}': all would have {grown} bytes: must be {MOST_BYTES} at most")
        self._values[name], self._bytes = text, grown
        return None

    def delete(self, name: str) -> None:
        """Remove a parameter from the store. Raises ValueError if it is not in the store."""
        if self._simulators(name) is not None:
            raise ValueError(f"parameter '{name}': belongs to the simulator: reset it with simulation/reset_parameters")
        text = self._values.pop(name, None)
        if text is None:
            raise ValueError(f"parameter '{name}': no parameter has this name")
        self._bytes -= _size(name, text)


def _size(name: str, text: str) -> int:
    """Return the memory [bytes] occupied by a value and its name."""
    return sys.getsizeof(name) + sys.getsizeof(text)
