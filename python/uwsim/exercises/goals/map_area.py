"""The goal `map`: the multibeam has swept an area."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from uwsim.base.polygon import inside
from uwsim.exercises.goal import GoalModel, Progress, Within
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import InRange, Point2


class _Mapping(Progress):
    def __init__(self, goal: MapArea) -> None:
        super().__init__(goal)
        corners = np.array(goal.area_m)
        self._low = corners.min(axis=0)
        counts = np.ceil((corners.max(axis=0) - self._low) / goal.cell_m).astype(int)
        middles = self._low + goal.cell_m * (np.moveaxis(np.indices(tuple(counts)), 0, -1) + 0.5)
        self._wanted = inside(middles.reshape(-1, 2), corners).reshape(counts)
        self._seen = np.zeros_like(self._wanted)
        self._due_s = 0.0

    def judge(self, moment: Moment, period_s: float) -> None:
        if moment.time_s < self._due_s - 1e-6:
            return
        self._due_s = moment.time_s + 1.0
        ping = moment.vehicle.sonar.ping()
        world_from_sonar = ping.world_from_sonar
        echoes = ping.points_sonar_m[ping.valid] @ world_from_sonar[:3, :3].T + world_from_sonar[:3, 3]
        cells = np.floor((echoes[:, :2] - self._low) / self._goal.cell_m).astype(int)
        cells = cells[((cells >= 0) & (cells < self._seen.shape)).all(axis=1)]
        self._seen[cells[:, 0], cells[:, 1]] = True
        found = float((self._seen & self._wanted).sum()) / max(int(self._wanted.sum()), 1)
        self.share = min(found / self._goal.share, 1.0)


class MapArea(GoalModel):
    """Sweep an area of the bed with the first multibeam sonar, which is read once per second.

    area_m: a polygon, x and y. cell_m: edge length of the cells into which it is divided. share: fraction of the cells
    that must have returned an echo for full points.
    """

    progress = _Mapping

    kind: Literal["map"]
    area_m: list[Point2] = Field(min_length=3, max_length=1000)
    cell_m: Within = 1.0
    share: Annotated[float, InRange(0.01, 1)] = 0.9
