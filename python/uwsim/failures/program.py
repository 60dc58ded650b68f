"""Programs that run aboard, in simulated time: failsafes and faults."""

from __future__ import annotations

from typing import Any, Protocol

NEVER = 2**62  # a tick that does not come


class Program(Protocol):
    """Acts at ticks of its own choice, before the step of that tick and after all commands of it.

    So what it does follows from the scenario and the commands, however many steps are made at once.
    """

    @property
    def due_tick(self) -> int:
        """The tick at which `act` is to be called next."""

    def act(self, tick: int) -> None:
        """Act; due_tick is later afterwards."""

    def save(self) -> dict[str, Any]:
        """Return, as JSON values, all that the future depends on."""

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from what `save` returned."""

    def restart(self) -> None:
        """Be as at the start of a run."""
