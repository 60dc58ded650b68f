"""Gate passing: find a gate by sonar and fly through it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.batch import Batch
from uwsim.learning.fan import ALTITUDE, ranges_field, seen_by_fan
from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Floats, Start, Task, Verdict, spread
from uwsim.scenario.obstacles.gates import Gate

PASSED, MISSED, STRUCK = 10.0, -5.0, -5.0
EFFORT_COST = 0.01
LOST_M = 18.0


class GatePassing(Task):
    """Fly through the scenario's gate, observed only through pings of a level sonar. The heading is not observed.

    Start: 6 to 11 m in front of the gate, at most 3 m to the side, 1.5 to 2.5 m above the bed, heading within 25
    degrees of the direction to the gate. Reward per step: the reduction in distance to the opening's centre in metres,
    minus 0.01 x the mean square of the efforts; 10 for passing between the posts and below the bar, -5 for passing
    anywhere else and -5 for a collision. Termination: any of these three, or a distance of 18 m from the gate.
    """

    scenario = PACKAGED / "gate.yaml"
    period_s = 0.1
    duration_s = 60.0
    axes = ("surge", "sway", "heave", "yaw")
    draws = 4
    pings = True
    sensors = ("altitude",)
    goal_fields = (ranges_field(64, 20.0), ALTITUDE)

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        super().__init__(batch, vehicle)
        gates = [item for item in batch.scenario.obstacles if isinstance(item, Gate)]
        if not gates:
            raise ValueError(f"scenario '{batch.scenario.name}': has no gate to pass")
        gate = gates[0]
        yaw = self._yaw_rad = math.radians(gate.yaw_deg)
        bed_m = float(batch.world.height_at(np.array([gate.position_m]))[0])
        self._half_width_m = 0.5 * gate.width_m - gate.bar_radius_m
        self._half_height_m = 0.5 * gate.height_m
        self._middle_m = np.array([*gate.position_m, bed_m + self._half_height_m])
        self._through = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        self._aside = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
        self._distance_m = np.zeros(batch.n)

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin in front of the gate."""
        away = spread(draws[:, 0], -11.0, -6.0)[:, None] * self._through
        away += spread(draws[:, 1], -3.0, 3.0)[:, None] * self._aside
        position_m = self._middle_m + away
        position_m[:, 2] += spread(draws[:, 2], -0.5, 0.5)
        yaw = np.arctan2(-away[:, 1], -away[:, 0]) + spread(draws[:, 3], -1.0, 1.0) * math.radians(25.0)
        self._distance_m[members] = np.linalg.norm(position_m - self._middle_m, axis=1)
        return Start(position_m, yaw)

    def goal(self, now: Motion) -> Floats:
        """Return sonar ranges and altitude."""
        return seen_by_fan(self.batch, self.vehicle, self.goal_fields)

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding approach and passing."""
        away = now.position_world_m - self._middle_m
        distance_m = np.linalg.norm(away, axis=1)
        beyond = away @ self._through > 0.0
        inside = (np.abs(away @ self._aside) < self._half_width_m) & (np.abs(away[:, 2]) < self._half_height_m)
        passed, missed, struck = beyond & inside, beyond & ~inside, now.collisions > 0
        reward = self._distance_m - distance_m - EFFORT_COST * (actions**2).mean(axis=1)
        reward += PASSED * passed + MISSED * missed + STRUCK * struck
        self._distance_m = distance_m
        ended = beyond | struck | (distance_m > LOST_M)
        return Verdict(reward, ended, {"distance_m": distance_m, "success": passed & ~struck})
