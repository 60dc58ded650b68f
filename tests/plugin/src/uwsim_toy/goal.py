"""The goal `spin`: the vehicle turns round."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from uwsim.exercises.goal import GoalModel, Progress
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import InRange


class Spin(GoalModel):
    """Turn round on the spot.

    turns: full turns to the left, in total; turning back undoes them.
    """

    kind: Literal["spin"]
    turns: Annotated[float, InRange(0.1, 100)] = 1.0

    def begun(self) -> Progress:
        """Return the goal's progress at the beginning."""
        return _Spinning(self)


class _Spinning(Progress):
    def __init__(self, goal: Spin) -> None:
        super().__init__()
        self._goal, self._yaw_rad, self._turned_rad = goal, math.nan, 0.0

    def judge(self, moment: Moment, period_s: float) -> None:
        if math.isfinite(self._yaw_rad):
            self._turned_rad += math.remainder(moment.yaw_rad - self._yaw_rad, math.tau)
        self._yaw_rad = moment.yaw_rad
        share = self._turned_rad / (math.tau * self._goal.turns)
        self.share = max(self.share, min(share, 1.0))
