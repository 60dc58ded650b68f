"""AreaPilot: travels between points of an area by its chart, and replans when the sonar reveals more."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.missions.heights import HIGHEST_Z_M
from uwsim.missions.planners.area_chart import AreaChart
from uwsim.missions.planners.wayfinder import GRACE_S, Wayfinder
from uwsim.missions.steps import Steps

ARRIVED_M = 1.0  # a waypoint counts as reached within this distance
CLIMB_S = 20.0  # time allowed to climb over an obstacle


class AreaPilot:
    """Flies with a lookout whose echoes are added to the chart."""

    def __init__(self, lookout: Wayfinder, chart: AreaChart) -> None:
        self.lookout, self.chart = lookout, chart

    def here(self) -> Floats:
        """Return the vehicle's position, (2,), and record it on the chart."""
        here = np.array(self.lookout.vehicle.pose.position_world_m[:2], np.float64)
        self.chart.visit(here)
        return here

    def go_to(
        self, goal: Floats, most_m: float = math.inf, enough: Callable[[], bool] = lambda: False
    ) -> Steps[bool | None]:
        """Travel to a point (2,) through open water until it is reached or `enough` returns true; return the outcome.

        Returns False if the point was closed or time ran out first, and None if the remaining path turned out to be
        longer than most_m.
        """
        here, vehicle = self.here(), self.lookout.vehicle
        way, last = self.chart.ways_from(here).to(goal), here
        if way is None:
            return False
        end_s = vehicle.time_s + GRACE_S + 5.0 * _length_m(here, way) / self.lookout.speed_m_s
        while len(way) and not enough():
            here = self.here()
            if float(np.linalg.norm(way[0] - here)) < ARRIVED_M:
                way, last = way[1:], way[0]
                continue
            if vehicle.time_s > end_s or not self.chart.open_at(goal[None])[0]:
                return False
            if not (yield from self.clear()) or not self.chart.straight(last, way[0]):
                here = self.here()
                way, last = self.chart.ways_from(here).to(goal), here
                if way is None:
                    return False
                if _length_m(here, way) > most_m:
                    return None
            yield from self.lookout.towards(way[0])
        return True

    def clear(self) -> Steps[bool]:
        """Climb over an obstacle close ahead; if this takes too long, mark it closed and return False."""
        lookout, vehicle = self.lookout, self.lookout.vehicle
        end_s = vehicle.time_s + CLIMB_S
        while lookout.must_stop:
            pose = vehicle.pose
            if vehicle.time_s > end_s or float(pose.position_world_m[2]) > HIGHEST_Z_M - 0.2:
                ahead = np.array([math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)])
                self.chart.close(self.here() + lookout.ahead_m * ahead)
                return False
            yield from lookout.steer(pose.yaw_rad, (0.0, 0.0))
        return True


def _length_m(here: Floats, way: Floats) -> float:
    return float(np.linalg.norm(np.diff(np.vstack([here, way]), axis=0), axis=1).sum())
