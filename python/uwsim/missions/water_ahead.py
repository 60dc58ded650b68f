"""is_water_ahead: judges by three beams of its tilted fan what is ahead of a vehicle that flies lanes.

As published: go on while any of the first, middle and last beams reads more than 7 m. Near the bed no beam does: over a
flat bed at height h, with the fan tilted down by t, the beam at an angle a to the middle one reads h / (sin t cos a).
So a beam that ends in the lower half of the water below the sonar has met the bed, which is passed over, and only an
echo from the upper half is of something ahead. A wall across the lane is then recognised at half the distance at which
the fan meets the bed, (h / 2) / tan t, whatever the beam.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from uwsim.navigation.control.protocols import PingLike

TURN_RANGE_M = 7.0  # as published
HALF_FAN_RAD = math.radians(42.5)  # of the published sonars; beams farther out look beside the lane, not along it
BED_SHARE = 0.5  # of the height above the bed: echoes in this part, from below, are of the bed


def is_water_ahead(ping: PingLike, bed_z_m: Callable[[], float]) -> bool:
    """Return whether a beam reads more than 7 m, or has met the bed; see above.

    bed_z_m: returns the height z of the bed below the vehicle, -inf if unknown; called if no beam reads that much.
    """
    beams, ranges_m = _three_beams(ping), ping.ranges_m
    if any(ranges_m[beam] > TURN_RANGE_M for beam in beams):
        return True
    up, sonar_z_m = ping.world_from_sonar[2, :3], float(ping.world_from_sonar[2, 3])
    below_m = -(np.asarray(ping.points_sonar_m)[list(beams)].astype(np.float64) @ up)
    return bool((below_m > (1.0 - BED_SHARE) * (sonar_z_m - bed_z_m())).any())  # false for NaN


def recognised_ahead_m(altitude_m: float, tilt_rad: float, half_fan_rad: float) -> float:
    """Return the distance to a wall across the lane at which `is_water_ahead` ends over a flat bed."""
    published_m = TURN_RANGE_M * math.cos(tilt_rad) * math.cos(min(half_fan_rad, HALF_FAN_RAD))
    return min(published_m, (1.0 - BED_SHARE) * altitude_m / max(math.tan(tilt_rad), 1e-9))


def _three_beams(ping: PingLike) -> tuple[int, int, int]:
    """Return the indices of the middle beam and of the outermost ones that look along the lane."""
    count, angles = len(ping.ranges_m), getattr(ping, "angles_rad", None)  # remote pings may not have them
    first, last = (0, count - 1) if angles is None else _along_lane(angles.dtype.str, angles.tobytes())
    return first, count // 2, last


@lru_cache(16)
def _along_lane(kind: str, angles: bytes) -> tuple[int, int]:
    """Return the indices of the outermost beams that look along the lane, by all beams' angles, which seldom change."""
    angles_rad = np.frombuffer(angles, kind)
    along = np.flatnonzero(np.abs(angles_rad) <= HALF_FAN_RAD + 1e-6)
    return (int(along[0]), int(along[-1])) if len(along) else (0, len(angles_rad) - 1)
