"""The goal `free_tether`: the tether can be drawn home."""

from __future__ import annotations

from typing import Annotated, Literal

from uwsim.exercises.goal import Duration, GoalModel
from uwsim.exercises.limits import require_turns
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import InRange
from uwsim.simulator.simulator import Simulator


class FreeTether(GoalModel):
    """Keep the tether free: whole, without a turn round an upright obstacle (docs/guides/tether.md), and short.

    It is judged once the goals in `after` are met. longest_m: how much of it may be out then; by default any. for_s:
    uninterrupted time.
    """

    kind: Literal["free_tether"]
    longest_m: Annotated[float, InRange(0.1, 20_000, "m")] | None = None
    for_s: Duration = 2.0

    def require(self, sim: Simulator) -> None:
        """See GoalModel."""
        require_turns(sim)

    def is_met_at(self, moment: Moment) -> bool:
        """See GoalModel."""
        tether = moment.vehicle.tether
        if tether is None:
            return False
        now = tether.read()
        is_short = self.longest_m is None or now.length_m <= self.longest_m
        return now.broken_at_m is None and not now.is_tangled and is_short
