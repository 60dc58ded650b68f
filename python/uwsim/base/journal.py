"""The journal of a simulator: reports each command to observers as it takes effect."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from uwsim.base.agenda import Agenda, Due, Rank

JUMPS = ("reset", "restore_state")
"""Commands that set the simulated time."""
EFFORT = "set_effort"
"""The steering command that is issued in every control period."""


@runtime_checkable
class CommandObserver(Protocol):
    """An object that is notified of commands, on the thread that issues them."""

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Handle a command that has just taken effect: one of uwsim.live.COMMANDS, restore_state or reset."""


class Observer(Due, Protocol):
    """An object that observes the simulator when due, before any command of that tick, without changing it."""

    def observe(self) -> None:
        """Observe the current state, and advance due_tick."""


class Journal:
    """Reports commands to observers. Without observers, reporting a command costs only the check of an empty tuple."""

    def __init__(self, agenda: Agenda) -> None:
        """agenda: schedules the observers."""
        self._agenda = agenda
        self.observers: tuple[CommandObserver, ...] = ()
        self.of_efforts: tuple[CommandObserver, ...] = ()

    def listen(self, observer: CommandObserver, *, efforts: bool = True) -> None:
        """Start passing commands to an observer. efforts: whether to include the very frequent set_effort."""
        self.observers = (*self.observers, observer)
        if efforts:
            self.of_efforts = (*self.of_efforts, observer)

    def attach(self, observer: Observer, *, efforts: bool = True) -> None:
        """Start calling an observer when it is due, and passing commands to it if it is also a CommandObserver."""
        if isinstance(observer, CommandObserver):
            self.listen(observer, efforts=efforts)
        self._agenda.add(observer, Rank.OBSERVER, lambda tick: observer.observe())

    def detach(self, observer: CommandObserver | Observer) -> None:
        """Undo `listen` or `attach`."""
        self.observers = tuple(other for other in self.observers if other is not observer)
        self.of_efforts = tuple(other for other in self.of_efforts if other is not observer)
        self._agenda.remove(observer)

    def note(self, name: str, /, **arguments: Any) -> None:
        """Report a command that has just taken effect."""
        for observer in self.of_efforts if name == EFFORT else self.observers:
            observer.commanded(name, arguments)
