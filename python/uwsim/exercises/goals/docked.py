"""The goal `docked`: the station's dock holds the vehicle."""

from __future__ import annotations

from typing import Literal

from uwsim.exercises.goal import GoalModel, Progress
from uwsim.exercises.moment import Moment


class Docked(GoalModel):
    """Dock at the station: `Dock` of the page, or the command `dock`, within the dock's limits of place and speed."""

    kind: Literal["docked"]

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Docking()


class _Docking(Progress):
    def judge(self, moment: Moment, period_s: float) -> None:
        if not moment.vehicle.released:
            self.share = 1.0
