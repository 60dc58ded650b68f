"""Valve: push a lever valve round by a quarter of a turn."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from uwsim.batch import Batch
from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Field, Floats, Start, Task, Verdict, spread

JAWS_BODY_M, CLOSED_M = np.array([0.44, 0.0, -0.10]), 0.04
"""The middle between the jaws of bluerov2_heavy_gripper, on the vehicle; how far each moves until they are closed."""
VALVE = "valve"
LEVER_UP_M, GRIP_M = 0.11, 0.24
TURNED_RAD, LOST_M = math.radians(85.0), 5.0
EFFORT_COST = 0.01


class Valve(Task):
    """Turn the lever of a valve by 85 degrees, from the south to the east, against its friction, with the gripper.

    Start: 1 to 1.4 m west of the lever, at most 0.3 m to the side and 0.2 m above or below, within 0.4 rad of east, in
    a current of up to 0.07 m/s. Reward per step: the approach of the jaws to the place 0.24 m along the lever in
    metres, plus 10 per radian that the lever turns, minus 0.01 x the mean square of the actions; 10 when it has turned
    by 85 degrees. Termination: that, or 5 m away.
    """

    scenario = PACKAGED / "valve.yaml"
    period_s = 0.1
    duration_s = 90.0
    axes = ("surge", "sway", "heave", "yaw")
    joints: ClassVar = {"grip": ("left", "right")}
    randomize: ClassVar = {"water.current_world_m_s.x": (-0.05, 0.05), "water.current_world_m_s.y": (-0.05, 0.05)}
    draws = 4
    goal_fields = (
        Field("spindle_body", 3, LOST_M, "m", "the vector from between the jaws to the spindle, at the lever's height",
              usual=(0.3,) * 3),
        Field("lever_body", 3, 1.0, "1", "the direction along the lever, from the spindle, in body axes"),
        Field("turned", 1, math.pi, "rad", "how far the lever has turned", usual=(1.0,)),
        Field("jaws", 2, CLOSED_M, "m", "how far each jaw has closed, left and right", 0.0, usual=(CLOSED_M,) * 2),
    )  # fmt: skip

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        super().__init__(batch, vehicle)
        self._spindle_m = batch.observe_object(VALVE).position_world_m[0] + [0.0, 0.0, LEVER_UP_M]
        self._distance_m, self._turned_rad = np.zeros(batch.n), np.zeros(batch.n)

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin west of the lever."""
        before_m = self._spindle_m - [0.0, GRIP_M, 0.0]
        ranges = ((1.0, 1.4), (-0.3, 0.3), (-0.2, 0.2), (-0.4, 0.4))
        back, aside, up, yaw = (spread(draws[:, k], low, high) for k, (low, high) in enumerate(ranges))
        from_place = np.column_stack([-back, aside, up])
        self._distance_m[members], self._turned_rad[members] = np.linalg.norm(from_place, axis=1), 0.0
        return Start(before_m + from_place - JAWS_BODY_M, yaw)

    def goal(self, now: Motion) -> Floats:
        """Return where the lever and the jaws are."""
        turned_rad = self._lever_rad()
        jaws_m = np.clip(self.batch.read_joints(self.vehicle).positions, 0.0, CLOSED_M)
        spindle = from_jaws(now, self._spindle_m)
        return np.column_stack([spindle, now.in_body(_along(turned_rad)), turned_rad, jaws_m])

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding approach and turning."""
        turned_rad = self._lever_rad()
        distance_m = np.linalg.norm(from_jaws(now, self._spindle_m + GRIP_M * _along(turned_rad)), axis=1)
        reward = self._distance_m - distance_m + 10.0 * (turned_rad - self._turned_rad)
        reward -= EFFORT_COST * (actions**2).mean(axis=1)
        self._distance_m, self._turned_rad = distance_m, turned_rad
        success = turned_rad >= TURNED_RAD
        return Verdict(
            reward + 10.0 * success, success | (distance_m > LOST_M), {"turned_rad": turned_rad, "success": success}
        )

    def _lever_rad(self) -> Floats:
        return self.batch.read_joints(VALVE).positions[:, 0]


def from_jaws(now: Motion, place_world_m: Floats) -> Floats:
    """Return the vector from the middle between the jaws to a position, (n, 3) or (3,), in body axes: (n, 3)."""
    return np.asarray(now.towards(place_world_m) - JAWS_BODY_M)


def _along(turned_rad: Floats) -> Floats:
    """Return the directions of levers in the world, (n, 3), which lead south at first."""
    return np.column_stack([np.sin(turned_rad), -np.cos(turned_rad), np.zeros_like(turned_rad)])
