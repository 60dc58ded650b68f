"""Lockstep: who makes the steps of a simulation, it alone or a source of steps such as an autopilot.

Recorded sources are repeated by entries of the group `uwsim.step_sources`, by the name of the command that holds their
frames: functions that receive the simulator and the command's arguments, and return a source.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from uwsim import _core
from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.base.sockets import load

GROUP = "uwsim.step_sources"
FRAME_BYTES = 64
"""32 pulse widths of 16 bits [us], little-endian; 0 for outputs that do not exist."""
StepSource = Callable[[int], object]
"""A function that makes steps, at most as many as its argument; a partner may make fewer."""


class Lockstep:
    """Advances the native simulation, either freely or by another source. advance: the source."""

    def __init__(self, core: _core.Simulation) -> None:
        self._free = core.step
        self.advance: StepSource = core.step

    @property
    def is_free(self) -> bool:
        """True if every requested step is made."""
        return self.advance == self._free

    def attach(self, advance: StepSource) -> None:
        """Let a source make all steps from now on."""
        self.advance = advance

    def detach(self) -> None:
        """Make every requested step again."""
        self.advance = self._free

    def play(self, sim: Any, **arguments: Any) -> None:
        """Repeat a source that was recorded: the command `servo_frames`. Raises ValueError, changing nothing."""
        source = load(GROUP, SERVO_FRAMES)(sim, **arguments)
        if not self.is_free:
            raise ValueError(f"{SERVO_FRAMES}: an autopilot makes the steps of this simulation")
        self.attach(source)
