"""Pipeline following: fly along a pipeline that is observed only by sonar."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.batch import Batch
from uwsim.learning.fan import ALTITUDE, ranges_field, seen_by_fan
from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Floats, Start, Task, Verdict, spread
from uwsim.learning.track import Track
from uwsim.scenario.obstacles.pipeline import Pipeline

ALTITUDE_M = 3.0
HALF_PAY_M = 1.0
LOST_M, END_M = 5.0, 3.0
ARRIVED, STRUCK, LOST = 10.0, -5.0, -5.0
HEIGHT_COST, EFFORT_COST = 0.02, 0.01
FIRST_SHARE = 0.6  # episodes begin within this initial share of the pipe's length


class PipelineFollowing(Task):
    """Follow the scenario's pipeline to its end, 3 m above the bed. The pipe is observed only through sonar pings.

    Start: along the pipe, at most 1.5 m to the side, within 20 degrees of its direction. Reward per step: progress
    along the pipe in metres / (1 + (cross-track error / 1 m)^2), minus 0.02 x |altitude - 3 m| and 0.01 x the mean
    square of the efforts; 10 for reaching the end of the pipe, -5 for losing it (5 m to the side) and -5 for a
    collision. Termination: any of these.
    """

    scenario = PACKAGED / "pipeline.yaml"
    period_s = 0.1
    duration_s = 120.0
    axes = ("surge", "sway", "heave", "yaw")
    draws = 4
    pings = True
    sensors = ("altitude",)
    goal_fields = (ranges_field(64, 20.0), ALTITUDE)

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        super().__init__(batch, vehicle)
        pipes = [item for item in batch.scenario.obstacles if isinstance(item, Pipeline)]
        if not pipes:
            raise ValueError(f"scenario '{batch.scenario.name}': has no pipeline to follow")
        self._track = Track(np.array(pipes[0].points_m, np.float64))
        self._along_m = np.zeros(batch.n)

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin near the pipe."""
        along_m = FIRST_SHARE * self._track.length_m * draws[:, 0]
        points, direction = self._track.at(along_m)
        aside = spread(draws[:, 1], -1.5, 1.5)[:, None] * np.stack([-direction[:, 1], direction[:, 0]], axis=1)
        z_m = self.batch.world.height_at(points + aside) + spread(draws[:, 2], 2.0, 4.0)
        yaw = np.arctan2(direction[:, 1], direction[:, 0]) + spread(draws[:, 3], -1.0, 1.0) * math.radians(20.0)
        position_m = np.column_stack([points + aside, z_m])
        self._along_m[members] = self._track.nearest(position_m[:, :2])[0]
        return Start(position_m, yaw)

    def goal(self, now: Motion) -> Floats:
        """Return sonar ranges and altitude."""
        return seen_by_fan(self.batch, self.vehicle, self.goal_fields)

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding progress along the pipe."""
        along_m, aside_m = self._track.nearest(now.position_world_m[:, :2])
        height_m = now.position_world_m[:, 2] - self.batch.world.height_at(now.position_world_m[:, :2])
        arrived = along_m > self._track.length_m - END_M
        lost, struck = aside_m > LOST_M, now.collisions > 0
        reward = (along_m - self._along_m) / (1.0 + (aside_m / HALF_PAY_M) ** 2)
        reward -= HEIGHT_COST * np.abs(height_m - ALTITUDE_M) + EFFORT_COST * (actions**2).mean(axis=1)
        reward += ARRIVED * arrived + LOST * lost + STRUCK * struck
        self._along_m = along_m
        return Verdict(reward, arrived | lost | struck, {"cross_track_m": aside_m, "success": arrived})
