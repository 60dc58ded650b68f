"""Tethered return: go to a place beyond a pile and back, without leaving the tether round the pile."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.batch import Batch
from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Field, Floats, Start, Task, Verdict, spread
from uwsim.scenario.obstacles.solids import Cylinder

NEAR_M = 0.8
REACHED, HOME, TANGLED, STRUCK = 5.0, 10.0, -10.0, -5.0
EFFORT_COST = 0.01
LOST_M = 20.0
HOME_M = np.array([-5.0, 0.0, -4.0])


class TetheredReturn(Task):
    """Go to a place beyond a pile and back on a tether of 16 m, and leave no turn of the tether round the pile.

    Start: 1 m from the anchor, 5 m in front of the pile. The place: 3.5 to 5 m behind the pile, at most 2 m to the
    side, 3 to 5 m deep. Reward per step: the approach in metres, first to the place and then to the start, minus 0.01 x
    the mean square of the efforts; 5 for reaching the place within 0.8 m, 10 for the return without a turn, -10 for
    each turn about the pile at the return, -5 for a collision. The turns are those of the vehicle's track, which its
    tether follows. Termination: the return, a collision, or 20 m away.
    """

    scenario = PACKAGED / "pile.yaml"
    period_s = 0.1
    duration_s = 120.0
    axes = ("surge", "sway", "heave", "yaw")
    draws = 4
    goal_fields = (
        Field("place_body", 3, LOST_M, "m", "the vector to the place, or then to the start", usual=(5.0,) * 3),
        Field("pile_body", 3, LOST_M, "m", "the vector to the pile at the vehicle's depth", usual=(5.0,) * 3),
        Field("is_returning", 1, 1.0, "1", "1 once the place has been reached", 0.0),
        Field("turned", 1, 3.0, "turns", "the angle passed about the pile since the start", usual=(0.5,)),
    )

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        super().__init__(batch, vehicle)
        piles = [item for item in batch.scenario.obstacles if isinstance(item, Cylinder)]
        if not piles:
            raise ValueError(f"scenario '{batch.scenario.name}': has no cylinder to go round")
        self._pile_m = np.array(piles[0].position_m[:2])
        self._places_m = np.zeros((batch.n, 3))
        self._distance_m, self._angle_rad, self._turned_rad = (np.zeros(batch.n) for _ in range(3))
        self._returns = np.zeros(batch.n, np.bool_)

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin near the anchor, and draw a place beyond the pile."""
        begin_m = np.tile(HOME_M, (len(members), 1))
        ahead, aside, depth = (
            spread(draws[:, k], low, high) for k, low, high in ((0, 3.5, 5.0), (1, -2.0, 2.0), (2, 3.0, 5.0))
        )
        self._places_m[members] = np.column_stack([self._pile_m[0] + ahead, self._pile_m[1] + aside, -depth])
        self._distance_m[members] = np.linalg.norm(self._places_m[members] - begin_m, axis=1)
        self._angle_rad[members] = self._angles(begin_m)
        self._turned_rad[members] = 0.0
        self._returns[members] = False
        return Start(begin_m, spread(draws[:, 3], -0.5, 0.5))

    def goal(self, now: Motion) -> Floats:
        """Return the vectors to the next place and to the pile, and what has been done."""
        pile_m = np.column_stack([np.tile(self._pile_m, (self.batch.n, 1)), now.position_world_m[:, 2]])
        turned = np.clip(self._turned_rad / (2.0 * math.pi), -3.0, 3.0)
        return np.column_stack([now.towards(self._next_m()), now.towards(pile_m), self._returns, turned])

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding approach and an untangled return."""
        angle = self._angles(now.position_world_m)
        self._turned_rad += (angle - self._angle_rad + math.pi) % (2.0 * math.pi) - math.pi
        self._angle_rad = angle
        distance_m = np.linalg.norm(now.position_world_m - self._next_m(), axis=1)
        reward = self._distance_m - distance_m - EFFORT_COST * (actions**2).mean(axis=1)
        there = distance_m < NEAR_M
        reached, home, struck = there & ~self._returns, there & self._returns, now.collisions > 0
        turns = np.round(self._turned_rad / (2.0 * math.pi))
        reward += REACHED * reached + STRUCK * struck + home * np.where(turns == 0, HOME, TANGLED * np.abs(turns))
        self._returns = self._returns | reached
        self._distance_m = np.linalg.norm(now.position_world_m - self._next_m(), axis=1)
        ended = home | struck | (distance_m > LOST_M)
        return Verdict(reward, ended, {"turns": turns, "success": home & (turns == 0) & ~struck})

    def _angles(self, position_m: Floats) -> Floats:
        away = position_m[:, :2] - self._pile_m
        return np.asarray(np.arctan2(away[:, 1], away[:, 0]))

    def _next_m(self) -> Floats:
        return np.where(self._returns[:, None], HOME_M, self._places_m)
