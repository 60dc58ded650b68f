"""The interface of a mission: what a survey needs of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable


class Mission(Protocol):
    """Flies its vehicle when it is run; AdaptiveLawnMower is one."""

    @property
    def progress(self) -> float:
        """Share of the mission that has been flown, 0..1."""

    def run(self) -> str:
        """Fly to the end; return why it ended."""


@runtime_checkable
class ResumableMission(Mission, Protocol):
    """A mission that another process can continue. A mission need not be resumable to fly."""

    def save(self) -> dict[str, Any]:
        """Return, as JSON values, everything that the rest of the mission depends on beside vehicle and clock.

        Called while the mission is in the clock's `wait`: what it does when that returns must follow from this state.
        """

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state that `save` returned; `run` then goes on as if `wait` had just returned.

        Raises ValueError.
        """
