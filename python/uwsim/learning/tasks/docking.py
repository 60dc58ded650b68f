"""Docking: enter the station's dock slowly and at the right heading."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.batch import Batch
from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Field, Floats, Start, Task, Verdict, spread
from uwsim.scenario.build.station import dock_position
from uwsim.simulator.docking import CAPTURE_DEG, CAPTURE_M_S

CAUGHT_M = 0.5  # the `dock` command allows 1.5 m
ARRIVED, STRUCK = 10.0, -1.0
TURN_PAY_M = 1.0  # per radian
EFFORT_COST = 0.01
LOST_M = 20.0


class Docking(Task):
    """Enter the dock: within 0.5 m of its centre, below 0.5 m/s and within 30 degrees of its heading.

    Start: 3 to 8 m ahead of the dock, at most 2 m to the side and 1 m above or below, within 60 degrees of its heading,
    in a current of up to 0.14 m/s. Reward per step: the approach in metres, plus 1 per radian turned towards the
    dock's heading, minus 0.01 x the mean square of the efforts; -1 for each new collision, 10 for docking. Termination:
    docked, or 20 m away.
    """

    scenario = PACKAGED / "dock.yaml"
    duration_s = 40.0
    axes = ("surge", "sway", "heave", "yaw")
    randomize = {"water.current_world_m_s.x": (-0.1, 0.1), "water.current_world_m_s.y": (-0.1, 0.1)}  # noqa: RUF012
    draws = 4
    goal_fields = (
        Field("dock_body", 3, LOST_M, "m", "the vector to the dock's centre, in body axes", usual=(5.0,) * 3),
        Field("dock_heading_body", 3, 1.0, "1", "the dock's heading as a unit vector in body axes"),
    )

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        super().__init__(batch, vehicle)
        station = batch.scenario.station
        yaw = math.radians(station.yaw_deg)
        self._yaw_rad = yaw
        self._dock_m = dock_position(station)
        self._ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        self._aside = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
        self._distance_m, self._off_rad = np.zeros(batch.n), np.zeros(batch.n)
        self._collisions = np.zeros(batch.n, np.uint64)

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin ahead of the dock."""
        away = (
            spread(draws[:, 0], 3.0, 8.0)[:, None] * self._ahead + spread(draws[:, 1], -2.0, 2.0)[:, None] * self._aside
        )
        away[:, 2] += spread(draws[:, 2], -1.0, 1.0)
        turned = spread(draws[:, 3], -1.0, 1.0) * math.pi / 3
        self._distance_m[members] = np.linalg.norm(away, axis=1)
        self._off_rad[members] = np.abs(turned)
        self._collisions[members] = 0
        return Start(self._dock_m + away, self._yaw_rad + turned)

    def goal(self, now: Motion) -> Floats:
        """Return the vector to the dock and the dock's heading, in body axes."""
        return np.concatenate([now.towards(self._dock_m), now.in_body(self._ahead)], axis=1)

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding approach and alignment."""
        distance_m = np.linalg.norm(now.position_world_m - self._dock_m, axis=1)
        off_rad = np.arccos(np.clip(now.world_from_body[:, :, 0] @ self._ahead, -1.0, 1.0))
        slow = np.linalg.norm(now.velocity_body[:, :3], axis=1) <= CAPTURE_M_S
        arrived = (distance_m <= CAUGHT_M) & slow & (off_rad <= math.radians(CAPTURE_DEG))
        struck = now.collisions - self._collisions
        reward = self._distance_m - distance_m + TURN_PAY_M * (self._off_rad - off_rad)
        reward += ARRIVED * arrived + STRUCK * struck - EFFORT_COST * (actions**2).mean(axis=1)
        self._distance_m, self._off_rad, self._collisions = distance_m, off_rad, now.collisions
        return Verdict(reward, arrived | (distance_m > LOST_M), {"distance_m": distance_m, "success": arrived})
