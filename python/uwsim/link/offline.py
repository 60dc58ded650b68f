"""A simulator that its owner steps, as a Carrier needs it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

from uwsim.live.commands import bound_command
from uwsim.live.subscription import Task
from uwsim.simulator import Simulator

T = TypeVar("T")
NEVER = 2**62


class Offline:
    """The names of a LiveSimulator that a Carrier uses: everything happens at once, in the caller's thread.

    A recorder must have begun before: what a tick says is read before what is sent at it.
    """

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator

    @property
    def tick(self) -> int:
        """The number of steps since the start."""
        return self.simulator.tick

    def command(self, name: str, /, **arguments: Any) -> Future[Any]:
        """Give a command; its error goes to the future."""
        return self.read(bound_command(name, arguments))

    def read(self, function: Callable[[Simulator], T]) -> Future[T]:
        """Call a function with the simulator."""
        future: Future[T] = Future()
        try:
            future.set_result(function(self.simulator))
        except ValueError as error:
            future.set_exception(error)
        return future

    def attend(self, task: Task) -> None:
        """Call the task's `deliver` at the ticks that it asks for, as the simulator is stepped."""
        self.simulator.journal.attach(_Attending(self.simulator, task))


class _Attending:
    """An observer of the journal that lets a task work."""

    def __init__(self, sim: Simulator, task: Task) -> None:
        self._sim, self._task = sim, task

    @property
    def due_tick(self) -> int:
        return NEVER if self._task.cancelled else self._task.due_tick

    def observe(self) -> None:
        """Let the task do what is due."""
        self._task.deliver(self._sim, self._sim.tick)

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """After a jump of time, begin anew."""
        if name in ("reset", "restore_state"):
            self._task.due_tick = self._sim.tick
