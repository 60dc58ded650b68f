"""The goal `reach`: the vehicle is at a place."""

from __future__ import annotations

from typing import Literal

from uwsim.exercises.goal import GoalModel, Within
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import Point3


class Reach(GoalModel):
    """Reach a position.

    position_m: position in the world. within_m: distance at which it counts as reached.
    """

    kind: Literal["reach"]
    position_m: Point3
    within_m: Within = 1.0

    def is_met_at(self, moment: Moment) -> bool:
        """See GoalModel."""
        return moment.distance_m(self.position_m) <= self.within_m
