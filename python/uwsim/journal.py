"""Who watches a simulator: observers see each command as it takes effect, and the ticks that they ask for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol


class Observer(Protocol):
    """Watches a simulator, on the thread that steps or commands it; must change nothing.

    due_tick: the tick at whose beginning `observe` is called next, before any command of that tick.
    """

    @property
    def due_tick(self) -> int:
        """The next tick to observe."""

    def observe(self) -> None:
        """Look at the present; due_tick is later afterwards."""

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Learn of a command that has just taken effect: a name of uwsim.live.COMMANDS, restore_state or reset."""


class Journal:
    """The observers of one simulator. Without any, a command costs one look at an empty tuple."""

    def __init__(self) -> None:
        self.observers: tuple[Observer, ...] = ()

    def attach(self, observer: Observer) -> None:
        """Let an observer watch from now on."""
        self.observers = (*self.observers, observer)

    def detach(self, observer: Observer) -> None:
        """Let it watch no more."""
        self.observers = tuple(other for other in self.observers if other is not observer)

    def note(self, name: str, /, **arguments: Any) -> None:
        """Tell all observers of a command that has just taken effect."""
        for observer in self.observers:
            observer.commanded(name, arguments)

    def step(self, steps: int, tick: int, advance: Callable[[int], None]) -> None:
        """Make steps by `advance`, in parts that end where an observer is due."""
        end = tick + steps
        while tick < end:
            due = min((observer.due_tick for observer in self.observers), default=end)
            part = min(max(due - tick, 1), end - tick)
            advance(part)
            tick += part
            for observer in self.observers:
                if observer.due_tick <= tick:
                    observer.observe()
