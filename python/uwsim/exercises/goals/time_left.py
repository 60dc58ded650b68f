"""The goal `time_left`: a bonus for the time that is left once other goals are met."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.exercises.goal import GoalModel, Progress
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import InRange, broken


class _Counted(Progress):
    is_met = False

    def judge(self, moment: Moment, period_s: float) -> None:
        left = (self._goal.none_s - moment.time_s) / (self._goal.none_s - self._goal.full_s)
        self.share, self.is_met = min(max(left, 0.0), 1.0), True


class TimeLeft(GoalModel):
    """Meet the goals named in `after` early.

    full_s: time up to which all points are awarded; none_s: time from which none are. In between in proportion.
    """

    progress = _Counted

    kind: Literal["time_left"]
    full_s: Annotated[float, InRange(0, 1e5, "s")] = 0.0
    none_s: Annotated[float, InRange(0.1, 1e5, "s")]

    @model_validator(mode="after")
    def _falls(self) -> TimeLeft:
        if not self.full_s < self.none_s:
            raise broken("must be less than none_s", at=("full_s",), value=self.full_s, unit="s")
        if not self.after:
            raise broken("must name the goals to be met early", at=("after",))
        return self
