"""ParameterTable: the one way to a live simulator's parameters, for rosbridge, ROS 2, Foxglove and the services."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from uwsim.base.journal import JUMPS
from uwsim.live import LiveSimulator, NotRunningError
from uwsim.simulator.parameters import Parameter
from uwsim.simulator.parameters import Parameters as Own

CHANGES = ("set_parameter", "set_parameters", "reset_parameters", "set_lamp", *JUMPS)
"""The commands that may change the values of parameters."""
UNSET = object()
"""Stands for a value that a client has omitted, which resets the parameter to the scenario's value."""


class ParameterTable:
    """The parameters of a live simulator, read on any thread and set by commands, which all clients' rights govern."""

    def __init__(self, live: LiveSimulator) -> None:
        self._live = live
        self._changed: Callable[[str, dict[str, Any]], object] = lambda command, arguments: None

    @property
    def own(self) -> Own:
        """The simulator's own mapping of them."""
        return self._live.simulator.parameters

    def known(self, names: Iterable[str]) -> list[Parameter | None]:
        """Return the description of each parameter; None for an unknown name, or for a group's."""
        found: list[Parameter | None] = []
        for name in names:
            try:
                found.append(self.own.describe(name))
            except ValueError:
                found.append(None)
        return found

    def values(self, names: Iterable[str] = ()) -> dict[str, Any]:
        """Return the values of the named parameters that exist, or of all parameters if no names are given."""
        own = self.own
        return {name: own[name] for name in list(names) or list(own) if name in own}

    def set(self, changes: Mapping[str, Any]) -> Future[Any]:
        """Set all or none; UNSET restores the scenario's value. The future has any error.

        Raises ValueError for an unknown name without a value, and NotRunningError.
        """
        full = {name: self.own.describe(name).default if value is UNSET else value for name, value in changes.items()}
        return self._live.command("set_parameters", changes=full)

    def reset(self, names: Iterable[str]) -> None:
        """Return to the scenario's values at and below each name, or to all without names. Raises ValueError."""
        for name in list(names) or (None,):
            self._live.command("reset_parameters", name=name).result()

    def listen(self, changed: Callable[[str, dict[str, Any]], object]) -> None:
        """Call a function, on the simulator's thread, with each command that may have changed values.

        Raises NotRunningError.
        """
        self._changed = changed
        self._live.read(lambda sim: sim.journal.listen(self, efforts=False))

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Report a command that may have changed parameters."""
        if name in CHANGES:
            self._changed(name, arguments)

    def close(self) -> None:
        """Stop reporting changes."""
        with suppress(NotRunningError):
            self._live.read(lambda sim: sim.journal.detach(self))
