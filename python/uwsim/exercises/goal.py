"""A goal of an exercise: a model with its YAML keys, and a Progress that judges moments 0.1 s apart.

Each kind is one file in `goals`, registered in the entry point group `uwsim.kinds.goal`; docs/inside/extend.md adds one
from another package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import Field

from uwsim.base.quaternions import turned_deg
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import InRange, Model, Name
from uwsim.scenario.spec.kinds import Kinds
from uwsim.scenario.spec.prop import PropEntry
from uwsim.simulator.simulator import Simulator

Duration = Annotated[float, InRange(0.1, 1e5, "s")]
Within = Annotated[float, InRange(0.01, 1000, "m")]
Points = Annotated[float, InRange(0, 1000)]


class Progress:
    """How much of a goal has been met. share: in [0, 1]. errors_m: deviations from the value to be held, if any.

    As it is, it counts the time without interruption in which the goal is met: for its for_s, or at once without one.
    """

    def __init__(self, goal: Any = None) -> None:
        self._goal, self._kept_s = goal, 0.0
        self.share = 0.0
        self.errors_m: list[float] = []
        self.times_s: list[float] = []

    @property
    def is_met(self) -> bool:
        """True once the goal has been met in full."""
        return self.share >= 1.0

    def judge(self, moment: Moment, period_s: float) -> None:
        """Judge the next moment, period_s after the last."""
        self.keep(self._goal.is_met_at(moment), period_s)

    def keep(self, is_met: bool, period_s: float) -> None:
        """Count the time in which the goal is met."""
        self._kept_s = self._kept_s + period_s if is_met else 0.0
        for_s = getattr(self._goal, "for_s", period_s)
        self.share = max(self.share, min(self._kept_s / for_s, 1.0))

    def note(self, time_s: float, error_m: float) -> None:
        """Record an error for the sheet."""
        self.times_s.append(time_s)
        self.errors_m.append(error_m)


class GoalModel(Model):
    """The keys that all goals share.

    name: used in `after`. title: shown to the pilot. points: awarded for meeting it. after: the name of a goal, or of
    several, that must be met before this one counts. of: a prop of the scenario, in whose frame the goal's position_m,
    heading_deg and pitch_deg are; by default the world.
    """

    progress: ClassVar[type[Progress]] = Progress

    name: Name
    title: str = Field(min_length=1, max_length=120)
    points: Points = 10.0
    after: Name | list[Name] | None = None
    of: Name | None = None

    if TYPE_CHECKING:
        kind: str
        pitch_deg: float

    @property
    def earlier(self) -> list[str]:
        """The names of the goals in `after`."""
        return [self.after] if isinstance(self.after, str) else list(self.after or ())

    def in_world(self, prop: PropEntry) -> Self:
        """Return a copy in the world for a goal in the frame of a prop."""
        changes: dict[str, Any] = {"of": None}
        if (point_m := getattr(self, "position_m", None)) is not None:
            changes["position_m"] = prop.in_world(point_m)
        if (heading_deg := getattr(self, "heading_deg", None)) is not None:
            leans = "pitch_deg" in type(self).model_fields
            own_deg = (heading_deg, self.pitch_deg if leans else 0.0, 0.0)
            changes["heading_deg"], pitch_deg, _ = turned_deg(own_deg, prop.turn_deg)
            changes |= {"pitch_deg": pitch_deg} if leans else {}
        return self.model_copy(update=changes)

    @property
    def places_m(self) -> list[tuple[float, float, float]]:
        """The points of a goal that has a position or a path, else none."""
        place = getattr(self, "position_m", None)
        return list(getattr(self, "points_m", ())) if place is None else [place]

    def begun(self) -> Progress:
        """Return the goal's progress at the beginning."""
        return self.progress(self)

    def is_met_at(self, moment: Moment) -> bool:
        """Return whether the goal is met at a moment, for a goal whose progress is a Progress as it is."""
        raise NotImplementedError

    def require(self, sim: Simulator) -> None:
        """Raise ValueError if the simulator's scenario lacks what the goal needs."""


GOALS = Kinds("uwsim.kinds.goal", GoalModel)
Goal = Annotated[GoalModel, GOALS]
