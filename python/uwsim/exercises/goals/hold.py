"""The goal `hold`: the vehicle stays where it is."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.base.quaternions import within_half_turn_deg
from uwsim.exercises.goal import Duration, GoalModel, Progress, Within
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import Degrees, InRange, Metres, Point3, broken


class _Holding(Progress):
    _goal: Hold

    def __init__(self, goal: Hold) -> None:
        super().__init__(goal)
        self._is_first = True

    def judge(self, moment: Moment, period_s: float) -> None:
        error_m = self._error_m(moment)
        is_kept = error_m <= self._goal.within_m and self._turned_deg(moment) <= self._goal.within_deg
        if is_kept:
            self._is_first = False
        if not self._is_first:
            self.note(moment.time_s, error_m)
        self.keep(is_kept, period_s)

    def _error_m(self, moment: Moment) -> float:
        found = [0.0]
        if self._goal.position_m is not None:
            found.append(moment.distance_m(self._goal.position_m))
        if self._goal.depth_m is not None:
            found.append(abs(self._goal.depth_m + float(moment.position_world_m[2])))
        return max(found)

    def _turned_deg(self, moment: Moment) -> float:
        if self._goal.heading_deg is None:
            return 0.0
        return abs(within_half_turn_deg(math.degrees(moment.yaw_rad) - self._goal.heading_deg))


class Hold(GoalModel):
    """Hold a position, a depth or a heading for some time without interruption.

    position_m: position in the world; within_m: distance from it. depth_m: positive down; within_m applies.
    heading_deg: counter-clockwise from east; within_deg: difference from it. for_s: how long.
    """

    progress = _Holding

    kind: Literal["hold"]
    position_m: Point3 | None = None
    depth_m: Metres | None = None
    heading_deg: Degrees | None = None
    within_m: Within = 0.5
    within_deg: Annotated[float, InRange(0.1, 180, "deg")] = 10.0
    for_s: Duration = 20.0

    @model_validator(mode="after")
    def _has_a_limit(self) -> Hold:
        if self.position_m is None and self.depth_m is None and self.heading_deg is None:
            raise broken("must have at least one of position_m, depth_m and heading_deg")
        return self
