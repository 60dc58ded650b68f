"""What a live simulator's log must know besides its commands: where somebody's look started a vehicle's navigation."""

from __future__ import annotations

from typing import Any

from uwsim.live.command_log import CommandLog, Entry
from uwsim.simulator import Simulator

NEVER = 2**62


class LogNavigation:
    """An Observer of the simulator's journal that logs the start of navigation, so that a replay starts it, too."""

    due_tick = NEVER

    def __init__(self, sim: Simulator, log: CommandLog) -> None:
        self._sim, self._log = sim, log

    def observe(self) -> None:
        """Nothing depends on time."""

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Log the start."""
        if name == "start_navigation":
            self._log.append(Entry(self._sim.tick, name, arguments))
