"""The goal `find`: cameras have seen what is to be found on an obstacle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from pydantic import Field

from uwsim.exercises.goal import Progress
from uwsim.exercises.goals.look_at import Sight
from uwsim.exercises.moment import Moment
from uwsim.scenario.build.solids import obstacle_parts
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.spec.fields import Name
from uwsim.scenario.spec.obstacle import places_by_kind
from uwsim.simulator.simulator import Simulator

ORDINARY = ("anode", "joint")
"""Kinds of marks that are no defects."""


class _Finding(Progress):
    def __init__(self, goal: Find) -> None:
        super().__init__(goal)
        self._seen_s = np.empty(0)
        self._places: np.ndarray | None = None

    def judge(self, moment: Moment, period_s: float) -> None:
        if self._places is None:
            self._places = self._goal.places(moment.sim)
            self._seen_s = np.zeros(len(self._places))
        for k, place in enumerate(self._places):
            if self._seen_s[k] < self._goal.for_s:
                self._seen_s[k] = self._seen_s[k] + period_s if self._goal.is_in_view(moment, place) else 0.0
        self.share = float((self._seen_s >= self._goal.for_s).mean())


class Find(Sight):
    """Find what there is to be found on an obstacle, such as the holes in a net, with the vehicle's cameras.

    obstacle: its name. marks: kinds of what is to be found there: hole of a net; damage, span, burial, debris, leak,
    anode and joint of a pipeline; by default all but anodes and joints. The share is that of the places that a camera
    has seen, each for_s without interruption.
    """

    progress = _Finding

    kind: Literal["find"]
    obstacle: Name
    marks: list[Name] = Field(default_factory=list)

    def require(self, sim: Simulator) -> None:
        """See GoalModel."""
        known = {one.name: marks(sim, one.name) for one in sim.scenario.obstacles}
        if not known.get(self.obstacle):
            possible = ", ".join(name for name, found in known.items() if found)
            rule = f"must be an obstacle with something to find: {possible or 'there is none'}"
            raise ValueError(f"obstacle = '{self.obstacle}': {rule}")
        there = known[self.obstacle]
        for kind in self.marks:
            if kind not in there:
                raise ValueError(f"marks = '{kind}': must be on '{self.obstacle}', which has {', '.join(there)}")
        if not len(self.places(sim)):
            raise ValueError(f"obstacle = '{self.obstacle}': has only {', '.join(there)}: name them under marks")

    def places(self, sim: Simulator) -> np.ndarray:
        """Return the places to be found, (n, 3)."""
        found = marks(sim, self.obstacle)
        kinds = self.marks or [kind for kind in found if kind not in ORDINARY]
        return np.concatenate([np.empty((0, 3)), *(found[kind] for kind in kinds)])


def marks(sim: Simulator, name: str) -> Mapping[str, np.ndarray]:
    """Return the places (n, 3) to be found on an obstacle, by kind."""
    terrain = build_terrain(sim.scenario.terrain)
    found = (obstacle_parts(one, terrain) for one in sim.scenario.obstacles if one.name == name)
    return places_by_kind(next(found, []))
