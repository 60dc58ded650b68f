"""Lockstep: who makes the steps of a simulation, it alone or a source of steps such as autopilots.

Recorded sources are repeated by entries of the group `uwsim.step_sources`, by the name of the command that holds their
frames: functions that receive the simulator, its present source and the command's arguments, and return a source.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from uwsim import _core
from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.base.sockets import load

GROUP = "uwsim.step_sources"
FRAME_BYTES = 64
"""32 pulse widths of 16 bits [us], little-endian; 0 for outputs that do not exist."""


class StepSource(Protocol):
    """A source of a simulation's steps."""

    def advance(self, steps: int) -> object:
        """Make steps, at most this many; a partner may make fewer."""


class Lockstep:
    """Advances the native simulation, either freely or by another source.

    source: None if every step is made. listeners: called when a source has begun to make the steps, or has ended.
    """

    def __init__(self, core: _core.Simulation) -> None:
        self._free = core.step
        self.source: StepSource | None = None
        self.advance: Callable[[int], object] = self._free
        self.listeners: tuple[Callable[[], object], ...] = ()

    @property
    def is_free(self) -> bool:
        """True if every requested step is made."""
        return self.source is None

    def attach(self, source: StepSource) -> None:
        """Let a source make all steps from now on."""
        self._switch(source, source.advance)

    def detach(self) -> None:
        """Make every requested step again."""
        self._switch(None, self._free)

    def _switch(self, source: StepSource | None, advance: Callable[[int], object]) -> None:
        was_free = self.is_free
        self.source, self.advance = source, advance
        if self.is_free != was_free:
            for listener in self.listeners:
                listener()

    def play(self, sim: Any, **arguments: Any) -> None:
        """Repeat a source that was recorded: the command `servo_frames`. Raises ValueError, changing nothing."""
        self.attach(load(GROUP, SERVO_FRAMES)(sim, self.source, **arguments))
