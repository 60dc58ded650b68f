"""The goal `pass`: the vehicle, or a loose body, passes through an opening."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from uwsim.exercises.goal import GoalModel, Progress, Within
from uwsim.exercises.goals.bring import require_loose
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import Degrees, Name, Point3
from uwsim.simulator.simulator import Simulator


class _Passing(Progress):
    def __init__(self, goal: Pass) -> None:
        super().__init__(goal)
        self._before = (0.0, np.zeros(3))
        heading, pitch = math.radians(goal.heading_deg), math.radians(goal.pitch_deg)
        level = math.cos(pitch)
        self._ahead = np.array([level * math.cos(heading), level * math.sin(heading), -math.sin(pitch)])
        self._has_before = False

    def judge(self, moment: Moment, period_s: float) -> None:
        place_m = moment.position_world_m
        if self._goal.object is not None:
            body = moment.sim.objects[self._goal.object]
            place_m = body.pose.position_world_m
            if body.carried:
                self._has_before = False
                return
        offset = place_m - np.array(self._goal.position_m)
        depth_m = float(offset @ self._ahead)
        (before_m, old), self._before = self._before, (depth_m, offset)
        if self._has_before and before_m < 0.0 <= depth_m:
            crossing = old + (offset - old) * (-before_m / (depth_m - before_m))
            error_m = float(np.linalg.norm(crossing))
            self.note(moment.time_s, error_m)
            if error_m <= self._goal.within_m:
                self.share = 1.0
        self._has_before = True


class Pass(GoalModel):
    """Pass through an opening, such as a gate.

    position_m: its centre. heading_deg: the direction of passage, counter-clockwise from east; pitch_deg: how far it
    leads down. within_m: its radius.
    object: the loose body that has to pass, such as a torpedo, once no dropper holds it; by default the vehicle.
    """

    progress = _Passing

    kind: Literal["pass"]
    position_m: Point3
    heading_deg: Degrees
    pitch_deg: Degrees = 0.0
    within_m: Within = 1.0
    object: Name | None = None

    def require(self, sim: Simulator) -> None:
        """See GoalModel."""
        if self.object is not None:
            require_loose(self.object, sim)
