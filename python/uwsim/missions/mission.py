"""What a survey needs of a mission."""

from __future__ import annotations

from typing import Protocol


class Mission(Protocol):
    """Flies its vehicle when it is run; see AdaptiveLawnMower for one."""

    @property
    def progress(self) -> float:
        """Share of the way that lies behind, 0..1."""

    def run(self) -> str:
        """Fly to the end; return what ended it."""
