"""The journal of a simulator: each command as it takes effect, for those who observe it."""

from __future__ import annotations

from typing import Any, Protocol

from uwsim.base.agenda import Agenda, Due, Rank

JUMPS = ("reset", "restore_state")
"""Commands that move the time."""


class CommandObserver(Protocol):
    """Learns of commands, on the thread that gives them."""

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Learn of a command that has just taken effect: a name of uwsim.live.COMMANDS, restore_state or reset."""


class Observer(CommandObserver, Due, Protocol):
    """Also looks at the simulator when it is due, before any command of that tick; must change nothing."""

    def observe(self) -> None:
        """Look at the present; due_tick is later afterwards."""


class Journal:
    """The log of commands. Without observers, a command costs one look at an empty tuple."""

    def __init__(self, agenda: Agenda) -> None:
        """agenda: where observers are due."""
        self._agenda = agenda
        self.observers: tuple[CommandObserver, ...] = ()

    def listen(self, observer: CommandObserver) -> None:
        """Pass commands on to an observer from now on."""
        self.observers = (*self.observers, observer)

    def attach(self, observer: Observer) -> None:
        """Pass commands on to an observer, and let it look when it is due, from now on."""
        self.listen(observer)
        self._agenda.add(observer, Rank.OBSERVER, lambda tick: observer.observe())

    def detach(self, observer: CommandObserver) -> None:
        """End what `listen` or `attach` began."""
        self.observers = tuple(other for other in self.observers if other is not observer)
        self._agenda.remove(observer)

    def note(self, name: str, /, **arguments: Any) -> None:
        """Pass on a command that has just taken effect."""
        for observer in self.observers:
            observer.commanded(name, arguments)
