"""The published simulator's adaptive lawn-mower as flown by its ROS node: observations in, commands out.

Source: UWRoboticsSimulator, ROS/controllerpkg/src/lawn_mower.py. The node steers by three beams of the level sonar and
the distance to port, in the sign conventions of the published messages. It uses neither depth nor a polygon, assumes
that the yaw is 0 at the start, and ends each turn 5 degrees early.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from itertools import cycle
from typing import NamedTuple

import numpy as np

START_M = (9.0, -144.0, 70.0)
ARRIVED_M = 1.0
NEAR_M = 7.0
STEP_ASIDE_M = 5.0
FULL_AHEAD = 4.0  # saturates at 1
TURNED_RAD = math.radians(5.0)
BEAMS = (0, 256, 512)


class Seen(NamedTuple):
    """The node's inputs: propPos, three beams of decodedDepth, and proximitySensor."""

    position_m: tuple[float, float, float]
    yaw_rad: float
    beams_m: tuple[float, float, float]
    port_m: float


class Key(NamedTuple):
    """A `key` message: efforts in the published sign convention (sway and yaw to starboard) and the function code."""

    surge: float = 0.0
    sway: float = 0.0
    heave: float = 0.0
    yaw: float = 0.0
    function: float = 0.0


STOP = Key()
RELEASE = Key(function=1.0)


def published_mower(start_m: tuple[float, float, float] = START_M) -> Generator[Key, Seen, None]:
    """Yield one key message per control period, given that period's observation; return at the end of the last lane.

    start_m: start of the lanes, in the propPos frame.
    """
    seen = yield RELEASE
    seen = yield from _go_to(start_m, seen)
    for to_starboard in cycle((True, False)):
        while max(seen.beams_m) > NEAR_M:
            seen = yield Key(surge=FULL_AHEAD)
        seen = yield STOP
        if not to_starboard and seen.port_m < NEAR_M:
            return
        while seen.yaw_rad > TURNED_RAD - math.pi if to_starboard else seen.yaw_rad < TURNED_RAD:
            seen = yield Key(yaw=1.0 if to_starboard else -1.0)
        seen = yield STOP
        if to_starboard and seen.port_m < NEAR_M:
            return
        lane_y_m = seen.position_m[1]
        while abs(seen.position_m[1] - lane_y_m) < STEP_ASIDE_M:
            seen = yield Key(sway=-1.0 if to_starboard else 1.0)
        seen = yield STOP


def _go_to(start_m: tuple[float, float, float], seen: Seen) -> Generator[Key, Seen, Seen]:
    while True:
        away = np.subtract(start_m, seen.position_m)
        distance_m = float(np.linalg.norm(away))
        if distance_m <= ARRIVED_M:
            return (yield STOP)
        surge, port, heave = (away / distance_m).tolist()
        seen = yield Key(surge=surge, sway=-port, heave=heave)
