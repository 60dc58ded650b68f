"""The journal of a simulator: reports each command, as it takes effect, to its observers."""

from __future__ import annotations

from typing import Any, Protocol

from uwsim.base.agenda import Agenda, Due, Rank

JUMPS = ("reset", "restore_state")
"""Commands that change the time."""


class CommandObserver(Protocol):
    """Is notified of commands, on the thread that issues them."""

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Handle a command that has just taken effect: a name of uwsim.live.COMMANDS, restore_state or reset."""


class Observer(CommandObserver, Due, Protocol):
    """Also observes the simulator when due, before any command of that tick; must change nothing."""

    def observe(self) -> None:
        """Observe the present state; due_tick is later afterwards."""


class Journal:
    """The log of commands. Without observers, a command only costs a check of an empty tuple."""

    def __init__(self, agenda: Agenda) -> None:
        """agenda: on which observers are scheduled."""
        self._agenda = agenda
        self.observers: tuple[CommandObserver, ...] = ()

    def listen(self, observer: CommandObserver) -> None:
        """Start passing commands to an observer."""
        self.observers = (*self.observers, observer)

    def attach(self, observer: Observer) -> None:
        """Start passing commands to an observer, and calling it when it is due."""
        self.listen(observer)
        self._agenda.add(observer, Rank.OBSERVER, lambda tick: observer.observe())

    def detach(self, observer: CommandObserver) -> None:
        """End the effect of `listen` or `attach`."""
        self.observers = tuple(other for other in self.observers if other is not observer)
        self._agenda.remove(observer)

    def note(self, name: str, /, **arguments: Any) -> None:
        """Pass on a command that has just taken effect."""
        for observer in self.observers:
            observer.commanded(name, arguments)
