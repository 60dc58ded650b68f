"""The options of `uwsim run` and `uwsim serve` with which a program outside flies the first vehicle."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from uwsim.base.options import Options, RegisteredOptions

if TYPE_CHECKING:
    from pathlib import Path

    from uwsim.live import LiveSimulator
    from uwsim.scenario import Scenario
    from uwsim.simulator.simulator import Simulator


class Autopilot(Options):
    """The base of an autopilot's options."""

    def scenario(self, scenario: str | Path) -> Scenario:
        """Return the scenario, prepared for the autopilot. Raises ScenarioError."""
        raise NotImplementedError

    def flying(self, simulator: Simulator | LiveSimulator) -> AbstractContextManager[str]:
        """Let the autopilot fly within a `with` statement; its value is the address, for the greeting."""
        raise NotImplementedError


class Autopilots(RegisteredOptions[Autopilot]):
    """The options of all autopilots that are registered; at most one is requested."""

    socket = "uwsim.autopilots"
    base = Autopilot


def prepared(autopilot: Autopilot | None, scenario: str | Path, **options: Any) -> Simulator:
    """Return a simulator of a scenario, prepared for an autopilot if there is one. Raises ScenarioError."""
    from uwsim.simulator.simulator import Simulator

    return Simulator(scenario if autopilot is None else autopilot.scenario(scenario), **options)
