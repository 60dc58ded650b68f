"""Gives bridges access to a live simulator's parameters, reports changes, and converts them to Foxglove's format."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from uwsim.base.journal import JUMPS
from uwsim.live import LiveSimulator, NotRunningError
from uwsim.simulator.simulator import Simulator

CHANGES = ("set_parameter", "set_parameters", "reset_parameters", "set_lamp", *JUMPS)
"""The commands that may change the values of parameters."""
UNSET = object()
"""Stands for a value that a client has omitted, which resets the parameter to the scenario's value."""


class Parameters:
    """A live simulator's parameters.

    changed: called on the simulator's thread when values may have changed, with the command and its arguments.
    """

    def __init__(self, live: LiveSimulator, changed: Callable[[str, dict[str, Any]], object]) -> None:
        self._live = live
        self._changed = changed

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Report a command that may have changed parameters."""
        if name in CHANGES:
            self._changed(name, arguments)

    def open(self) -> None:
        """Start reporting changes. Raises NotRunningError."""
        self._live.read(self._listen)

    def close(self) -> None:
        """Stop reporting changes."""
        with suppress(NotRunningError):
            self._live.read(lambda sim: sim.journal.detach(self))

    def _listen(self, sim: Simulator) -> None:
        sim.journal.listen(self, efforts=False)

    def unknown(self, names: Iterable[str]) -> list[str]:
        """Return those of the names that belong to no parameter."""
        own = self._live.simulator.parameters
        return [name for name in names if name not in own]

    def values(self, names: Iterable[str]) -> dict[str, Any]:
        """Return the values of the named parameters that exist, or of all parameters if no names are given."""
        own = self._live.simulator.parameters
        return {name: own[name] for name in list(names) or list(own) if name in own}

    def set(self, changes: Mapping[str, Any], done: Callable[[str | None], object]) -> None:
        """Set all or none of the parameters. UNSET restores the scenario's value. `done` receives any error.

        Raises ValueError for an unknown name without a value, and NotRunningError.
        """
        own = self._live.simulator.parameters
        full = {name: own.describe(name).default if value is UNSET else value for name, value in changes.items()}

        def finish(order: Future[Any]) -> None:
            error = None if order.cancelled() else order.exception()
            done(None if error is None else str(error))

        self._live.command("set_parameters", changes=full).add_done_callback(finish)


def described(name: str, value: Any) -> dict[str, Any]:
    """Return a parameter in the protocol's format, without a value if it has none."""
    if value is None:
        return {"name": name}
    kind: dict[str, str] = {}
    if isinstance(value, float):
        kind = {"type": "float64"}
    elif isinstance(value, list | tuple) and value and all(isinstance(part, float) for part in value):
        kind = {"type": "float64_array"}
    return {"name": name, "value": value, **kind}
