"""What a survey needs of a mission."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable


class Mission(Protocol):
    """Flies its vehicle when it is run; see AdaptiveLawnMower for one."""

    @property
    def progress(self) -> float:
        """Share of the way that lies behind, 0..1."""

    def run(self) -> str:
        """Fly to the end; return what ended it."""


@runtime_checkable
class ResumableMission(Mission, Protocol):
    """A mission that another process may take up where this one left it. One that is not still flies."""

    def save(self) -> dict[str, Any]:
        """All that its way ahead depends on beside vehicle and clock, as JSON knows it.

        Asked for while the mission is in the clock's `wait`: what it will do when that returns must follow from this.
        """

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `save` gave; `run` then goes on as if `wait` had just returned. Raises ValueError."""
