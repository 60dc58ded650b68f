"""Station keeping: hold a position and heading in a gusty current."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.learning.motion import Motion
from uwsim.learning.task import PACKAGED, Field, Floats, Start, Task, Verdict, spread

PLACE_M = np.array([0.0, 0.0, -7.0])
HALF_PAY_M = 0.2  # the distance at which the reward is halved
EFFORT_COST = 0.02
LOST_M = 5.0


class StationKeeping(Task):
    """Hold PLACE_M, heading east and level, in a current of up to 0.42 m/s with gusts of 0.2 m/s rms.

    Start: within 1 m of PLACE_M along each axis, and within 45 degrees of the heading. Reward per step: (1 + cos
    heading error) / 2 / (1 + distance / 0.2 m) - 0.02 x the mean square of the efforts: at most 1. Termination: 5 m
    from the target.
    """

    scenario = PACKAGED / "open_water.yaml"
    randomize = {"water.current_world_m_s.x": (-0.3, 0.3), "water.current_world_m_s.y": (-0.3, 0.3)}  # noqa: RUF012
    draws = 4
    place_m = PLACE_M
    goal_fields = (
        Field("place_body", 3, 10.0, "m", "the vector to the target, in body axes", usual=(0.2,) * 3),
        Field("heading_body", 3, 1.0, "1", "the target heading's unit vector, in body axes", usual=(1.0, 0.3, 0.3)),
    )

    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin near the target."""
        return Start(self.place_m + spread(draws[:, :3], -1.0, 1.0), spread(draws[:, 3], -1.0, 1.0) * math.pi / 4)

    def goal(self, now: Motion) -> Floats:
        """Return the vector to the target and the target heading."""
        return way_to(self.place_m, now)

    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the verdict, rewarding proximity to the target and its heading."""
        distance_m = np.linalg.norm(now.position_world_m - self.place_m, axis=1)
        facing = 0.5 * (1.0 + now.heading[:, 0])
        reward = facing / (1.0 + distance_m / HALF_PAY_M) - EFFORT_COST * (actions**2).mean(axis=1)
        return Verdict(reward, distance_m > LOST_M, {"distance_m": distance_m})


def way_to(place_m: Floats, now: Motion) -> Floats:
    """Return the vector to a position (3,) and the unit vector east, both in body axes: (n, 6)."""
    return np.concatenate([now.towards(place_m), now.world_from_body[:, 0, :]], axis=1)
