"""The goal `find`: cameras have seen what is to be found on an obstacle."""

from __future__ import annotations

from typing import Literal

import numpy as np

from uwsim.exercises.goal import Progress
from uwsim.exercises.goals.look_at import Sight
from uwsim.exercises.moment import Moment
from uwsim.scenario.build.obstacles import grounded
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.spec.fields import Name
from uwsim.simulator.simulator import Simulator


class Find(Sight):
    """Find what there is to be found on an obstacle, such as the holes in a net, with the vehicle's cameras.

    obstacle: its name. The share is that of the places that a camera has seen, each for_s without interruption; see
    Sight.
    """

    kind: Literal["find"]
    obstacle: Name

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Finding(self)

    def require(self, sim: Simulator) -> None:
        """See GoalModel."""
        known = [one.name for one in sim.scenario.obstacles if len(marks_m(sim, one.name))]
        if self.obstacle not in known:
            rule = f"must be an obstacle with something to find: {', '.join(known) or 'there is none'}"
            raise ValueError(f"obstacle = '{self.obstacle}': {rule}")


class _Finding(Progress):
    def __init__(self, goal: Find) -> None:
        super().__init__()
        self._goal, self._seen_s = goal, np.empty(0)
        self._places: np.ndarray | None = None

    def judge(self, moment: Moment, period_s: float) -> None:
        if self._places is None:
            self._places = marks_m(moment.sim, self._goal.obstacle)
            self._seen_s = np.zeros(len(self._places))
        for k, place in enumerate(self._places):
            if self._seen_s[k] < self._goal.for_s:
                self._seen_s[k] = self._seen_s[k] + period_s if self._goal.is_in_view(moment, place) else 0.0
        self.share = float((self._seen_s >= self._goal.for_s).mean())


def marks_m(sim: Simulator, name: str) -> np.ndarray:
    """Return the places (n, 3) to be found on an obstacle."""
    terrain = build_terrain(sim.scenario.terrain)
    found = [grounded(one, terrain).marks_m() for one in sim.scenario.obstacles if one.name == name]
    return found[0] if found else np.empty((0, 3))
