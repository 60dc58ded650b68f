"""The goal `reach`: the vehicle is at a place."""

from __future__ import annotations

from typing import Literal

from uwsim.exercises.goal import GoalModel, Progress, Within
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import Point3


class Reach(GoalModel):
    """Reach a position.

    position_m: position in the world. within_m: distance at which it counts as reached.
    """

    kind: Literal["reach"]
    position_m: Point3
    within_m: Within = 1.0

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Reaching(self)


class _Reaching(Progress):
    def __init__(self, goal: Reach) -> None:
        super().__init__()
        self._goal = goal

    def judge(self, moment: Moment, period_s: float) -> None:
        if moment.distance_m(self._goal.position_m) <= self._goal.within_m:
            self.share = 1.0
