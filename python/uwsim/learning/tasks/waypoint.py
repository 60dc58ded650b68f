"""Waypoint: move to a position in a current, and come to rest there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.batch import Batch
from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Field, Floats, Start, Task, Verdict, spread

NEAR_M, SLOW_M_S = 0.5, 0.3
ARRIVED, STRUCK = 10.0, -5.0
EFFORT_COST = 0.02
LOST_M = 25.0
BASIN_M = np.array([8.0, 8.0, 3.0])
MIDDLE_M = np.array([0.0, 0.0, -7.0])


class Waypoint(Task):
    """Move from one position to another, both drawn in a box of 16 x 16 x 6 m, in a gusty current of up to 0.28 m/s.

    Reward per step: the approach in metres, minus 0.02 x the mean square of the efforts; 10 for arriving, within 0.5 m
    and slower than 0.3 m/s; -5 for a collision. Termination: arrival, a collision, or 25 m away.
    """

    scenario = PACKAGED / "open_water.yaml"
    duration_s = 60.0
    randomize = {"water.current_world_m_s.x": (-0.2, 0.2), "water.current_world_m_s.y": (-0.2, 0.2)}  # noqa: RUF012
    draws = 7
    goal_fields = (Field("place_body", 3, LOST_M, "m", "the vector to the target, in body axes", usual=(5.0,) * 3),)

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        super().__init__(batch, vehicle)
        self._places_m = np.zeros((batch.n, 3))
        self._distance_m = np.zeros(batch.n)

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin at one random position and draw another as the target."""
        begin_m, place_m = (MIDDLE_M + BASIN_M * spread(draws[:, k : k + 3], -1.0, 1.0) for k in (0, 3))
        self._places_m[members] = place_m
        self._distance_m[members] = np.linalg.norm(place_m - begin_m, axis=1)
        return Start(begin_m, spread(draws[:, 6], -math.pi, math.pi))

    def goal(self, now: Motion) -> Floats:
        """Return the vector to the target."""
        return now.towards(self._places_m)

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding approach."""
        distance_m = np.linalg.norm(now.position_world_m - self._places_m, axis=1)
        slow = np.linalg.norm(now.velocity_body[:, :3], axis=1) < SLOW_M_S
        arrived, struck = (distance_m < NEAR_M) & slow, now.collisions > 0
        reward = self._distance_m - distance_m - EFFORT_COST * (actions**2).mean(axis=1)
        reward += ARRIVED * arrived + STRUCK * struck
        self._distance_m = distance_m
        ended = arrived | struck | (distance_m > LOST_M)
        return Verdict(reward, ended, {"distance_m": distance_m, "success": arrived})
