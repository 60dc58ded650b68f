"""The goal `follow`: the vehicle follows a path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
from pydantic import Field

from uwsim.exercises.goal import GoalModel, Progress, Within
from uwsim.exercises.moment import Floats, Moment
from uwsim.scenario.spec.fields import Point3

STATIONS_M = 0.5  # spacing of the points of a path that must be passed


class _Following(Progress):
    def __init__(self, goal: Follow) -> None:
        super().__init__(goal)
        self._within_m = goal.within_m
        self._stations, self._corners = _stations(goal.points_m), np.array(goal.points_m, np.float64)
        self._next = 0

    def judge(self, moment: Moment, period_s: float) -> None:
        away_m = np.linalg.norm(self._stations - moment.position_world_m, axis=1)
        while self._next < len(away_m) and away_m[self._next] <= self._within_m:
            self._next += 1
        if 0 < self._next < len(self._stations):
            self.note(moment.time_s, _distance_m(moment.position_world_m, self._corners))
        self.share = self._next / len(self._stations)


class Follow(GoalModel):
    """Follow a path from its first point to its last.

    points_m: its corners. within_m: allowed distance from the path. The goal's share is the share of the path's length
    passed in order: a pilot who leaves the path must return to the point of departure.
    """

    progress = _Following

    kind: Literal["follow"]
    points_m: list[Point3] = Field(min_length=2, max_length=1000)
    within_m: Within = 1.0


def _distance_m(point: Floats, corners: Floats) -> float:
    """Return the distance from a point (3,) to straight legs through corners (n, 3)."""
    starts, legs = corners[:-1], np.diff(corners, axis=0)
    along = np.einsum("ij,ij->i", point - starts, legs) / np.maximum(np.einsum("ij,ij->i", legs, legs), 1e-12)
    nearest = starts + np.clip(along, 0.0, 1.0)[:, None] * legs
    return float(np.linalg.norm(nearest - point, axis=1).min())


def _stations(corners: Sequence[Point3]) -> Floats:
    """Return points (n, 3) along straight legs, at most STATIONS_M apart."""
    found = [np.array(corners[0], np.float64)]
    for start, end in pairwise(corners):
        first, last = np.array(start), np.array(end)
        count = max(1, math.ceil(float(np.linalg.norm(last - first)) / STATIONS_M))
        found += [first + (last - first) * k / count for k in range(1, count + 1)]
    return np.array(found)
