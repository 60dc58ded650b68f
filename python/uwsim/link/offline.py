"""Offline: provides the interface that a Carrier needs, for a simulator that is stepped by its owner."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

from uwsim.base.commands import bound_command
from uwsim.simulator.simulator import Simulator

T = TypeVar("T")


class Offline:
    """Implements the LiveSimulator methods that a Carrier uses, by executing each call immediately."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator

    def command(self, name: str, /, **arguments: Any) -> Future[Any]:
        """Issue a command. Any error is stored in the future."""
        return self.read(bound_command(name, arguments))

    def read(self, function: Callable[[Simulator], T]) -> Future[T]:
        """Call a function with the simulator, and store its result or ValueError in the future."""
        future: Future[T] = Future()
        try:
            future.set_result(function(self.simulator))
        except ValueError as error:
            future.set_exception(error)
        return future
