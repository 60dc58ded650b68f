"""The goal `move_joint`: a joint of an object has been brought to a position."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from uwsim.base.named import did_you_mean
from uwsim.exercises.goal import GoalModel, Progress
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import InRange, Name, broken
from uwsim.simulator.simulator import Simulator


class _Moving(Progress):
    def __init__(self, goal: MoveJoint) -> None:
        super().__init__(goal)
        self._first: float | None = None
        self._end = math.radians(goal.to_deg) if goal.to_deg is not None else float(goal.to_m or 0.0)

    def judge(self, moment: Moment, period_s: float) -> None:
        now = self._goal.position(moment.sim)
        assert now is not None  # `require` has seen it
        if self._first is None:
            self._first = now
        whole = self._end - self._first
        self.share = max(self.share, min((now - self._first) / whole, 1.0) if whole else 1.0)


class MoveJoint(GoalModel):
    """Turn or move a joint of an object, such as a valve's handle, as far as a position.

    object: one of the scenario's `objects`, with links. joint: the name of its link. to_deg: for a hinge; to_m: for a
    slide. It counts in proportion to the farthest way from where the joint begins.
    """

    progress = _Moving
    one_of = ("to_deg", "to_m")

    kind: Literal["move_joint"]
    object: Name
    joint: Name
    to_deg: Annotated[float, InRange(-36_000, 36_000, "deg")] | None = Field(None, examples=[90])
    to_m: Annotated[float, InRange(-100, 100, "m")] | None = None

    @model_validator(mode="after")
    def _has_one_end(self) -> MoveJoint:
        if (self.to_deg is None) == (self.to_m is None):
            raise broken("give one of to_deg and to_m", at=("to_deg",), value=self.to_deg)
        return self

    def require(self, sim: Simulator) -> None:
        """See GoalModel."""
        known = [name for name, body in sim.objects.items() if body.joints is not None]
        if self.object not in known:
            rule = f"must be one of {', '.join(known)}" if known else "no object has links"
            raise ValueError(f"object = '{self.object}': {rule}{did_you_mean(self.object, known)}")
        if self.position(sim) is None:
            joints = sim.objects[self.object].joints
            raise ValueError(f"joint = '{self.joint}': must be one of {', '.join(joints.names if joints else ())}")

    def position(self, sim: Simulator) -> float | None:
        """Return where the joint is [rad or m]; None if there is no such joint."""
        joints = sim.objects[self.object].joints
        if joints is None or self.joint not in joints.names:
            return None
        return float(joints.read().positions[joints.names.index(self.joint)])
