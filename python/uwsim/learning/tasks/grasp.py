"""Grasp: take a sample between the jaws, and lift it off its table."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from uwsim.batch import Batch
from uwsim.learning.gripper import CLOSED_M, GRIP, from_jaws, west_of
from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Field, Floats, Start, Task, Verdict

SAMPLE = "sample"
LIFT_M, HELD_M, FALLEN_M, LOST_M = 0.3, 0.08, 0.1, 5.0
EFFORT_COST = 0.01


class Grasp(Task):
    """Take a sample of 50 mm between the jaws of a gripper, by friction alone, and lift it by 0.3 m.

    Start: 0.8 to 1.2 m west of the sample, at most 0.3 m to the side and 0.2 m above or below, within 0.4 rad of its
    direction, in a current of up to 0.07 m/s. Reward per step: the approach of the jaws to the sample in metres, plus
    10 per metre that the sample rises while its middle is within 0.08 m of the jaws', minus 0.01 x the mean square of
    the actions; 10 when it is 0.3 m above its place there, -5 when it falls off. Termination: either of these, or 5 m
    away.
    """

    scenario = PACKAGED / "sample.yaml"
    period_s = 0.1
    duration_s = 60.0
    axes = ("surge", "sway", "heave", "yaw")
    joints = GRIP
    randomize: ClassVar = {"water.current_world_m_s.x": (-0.05, 0.05), "water.current_world_m_s.y": (-0.05, 0.05)}
    draws = 4
    goal_fields = (
        Field("sample_body", 3, LOST_M, "m", "the vector from between the jaws to the sample", usual=(0.2,) * 3),
        Field("lifted", 1, 1.0, "m", "how far the sample is above its place on the table", usual=(LIFT_M,)),
        Field("jaws", 2, CLOSED_M, "m", "how far each jaw has closed, left and right", 0.0, usual=(CLOSED_M,) * 2),
    )

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        super().__init__(batch, vehicle)
        self._place_m = np.array(batch.observe_object(SAMPLE).position_world_m[0])
        self._distance_m, self._lifted_m = np.zeros(batch.n), np.zeros(batch.n)

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin west of the sample."""
        begun, self._distance_m[members] = west_of(self._place_m, (0.8, 1.2), draws)
        self._lifted_m[members] = 0.0
        return begun

    def goal(self, now: Motion) -> Floats:
        """Return where the sample and the jaws are."""
        sample_m = self.batch.observe_object(SAMPLE).position_world_m
        lifted_m = np.clip(sample_m[:, 2] - self._place_m[2], -1.0, 1.0)
        jaws_m = np.clip(self.batch.read_joints(self.vehicle).positions, 0.0, CLOSED_M)
        return np.column_stack([from_jaws(now, sample_m), lifted_m, jaws_m])

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding approach and lift."""
        sample_m = self.batch.observe_object(SAMPLE).position_world_m
        distance_m = np.linalg.norm(from_jaws(now, sample_m), axis=1)
        above_m = sample_m[:, 2] - self._place_m[2]
        lifted_m = np.where(distance_m < HELD_M, np.clip(above_m, 0.0, LIFT_M), 0.0)
        reward = self._distance_m - distance_m + 10.0 * (lifted_m - self._lifted_m)
        reward -= EFFORT_COST * (actions**2).mean(axis=1)
        self._distance_m, self._lifted_m = distance_m, lifted_m
        success, fallen = lifted_m >= LIFT_M, above_m < -FALLEN_M
        reward += 10.0 * success - 5.0 * fallen
        return Verdict(reward, success | fallen | (distance_m > LOST_M), {"lifted_m": above_m, "success": success})
