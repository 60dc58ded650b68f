"""The gripper of the tasks that have one: where its jaws are, on the vehicle and as joints."""

from __future__ import annotations

import numpy as np

from uwsim.learning.motion import Motion
from uwsim.learning.task import Floats, Start, spread

JAWS_BODY_M = np.array([0.44, 0.0, -0.10])
"""The middle between the jaws of bluerov2_heavy_gripper, on the vehicle."""

GRIP = {"grip": ("left", "right")}
"""The value of an action that closes both jaws, from 0; they are closed at 0.04 m."""

CLOSED_M = 0.04


def from_jaws(now: Motion, place_world_m: Floats) -> Floats:
    """Return the vector from the middle between the jaws to a position, (n, 3) or (3,), in body axes: (n, 3)."""
    return np.asarray(now.towards(place_world_m) - JAWS_BODY_M)


def west_of(place_world_m: Floats, back_m: tuple[float, float], draws: Floats) -> tuple[Start, Floats]:
    """Return starts (m) with the jaws west of a position, and how far they are from it (m,).

    draws: (m, 4). back_m: how far west. At most 0.3 m to the side, 0.2 m above or below, and 0.4 rad from east.
    """
    ranges = (back_m, (-0.3, 0.3), (-0.2, 0.2), (-0.4, 0.4))
    back, aside, up, yaw = (spread(draws[:, k], low, high) for k, (low, high) in enumerate(ranges))
    from_place = np.column_stack([-back, aside, up])
    return Start(place_world_m + from_place - JAWS_BODY_M, yaw), np.linalg.norm(from_place, axis=1)
