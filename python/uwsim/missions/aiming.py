"""Steps that turn a sonar's head or a camera and wait until it points in the requested direction."""

from __future__ import annotations

import math
from typing import Any

from uwsim.missions.steps import Steps, StoppedError, until

TOLERANCE_RAD = math.radians(0.5)
HEAD_TIMEOUT_S = 60.0


def is_at(sonar: Any, elevation_rad: float) -> bool:
    """Return whether the head has reached an elevation; always True for a sonar that does not report its elevation."""
    return bool(abs(getattr(sonar, "elevation_rad", elevation_rad) - elevation_rad) <= TOLERANCE_RAD)


def until_at(sonar: Any, elevation_rad: float) -> Steps[bool]:
    """Wait on the spot until the head reaches an elevation; return False on timeout."""
    return until(lambda: is_at(sonar, elevation_rad), timeout_s=HEAD_TIMEOUT_S)


TIMEOUT_S = 120.0
"""Longer than any packaged head needs for half a turn; a slower head needs a longer timeout_s."""


def aim_to(
    head: Any,
    elevation_rad: float | None = None,
    *,
    pan_rad: float | None = None,
    tilt_rad: float | None = None,
    timeout_s: float = TIMEOUT_S,
) -> Steps[None]:
    """Turn a multibeam's head to an elevation, or a camera to pan and tilt, and wait until it points there.

    head: a sonar or camera, such as vehicle.sonar or vehicle.cameras["front"]. elevation_rad: elevation of a sonar,
    positive up. pan_rad: pan of a camera, positive to port. tilt_rad: tilt of a camera, positive down; None leaves an
    axis unchanged. Raises ValueError for angles that the head does not have or cannot reach, and StoppedError if it has
    not arrived after timeout_s.
    """
    if elevation_rad is not None and (pan_rad is not None or tilt_rad is not None):
        raise ValueError("aim_to: either elevation_rad, of a sonar, or pan_rad and tilt_rad, of a camera")
    if elevation_rad is not None:
        head.aim(elevation_rad)
    elif pan_rad is not None or tilt_rad is not None:
        head.aim(pan_rad=pan_rad, tilt_rad=tilt_rad)
    else:
        raise ValueError("aim_to: needs elevation_rad, of a sonar, or pan_rad or tilt_rad, of a camera")
    if not (yield from until(lambda: head.is_aimed, timeout_s=timeout_s)):
        raise StoppedError(f"'{head.name}' has not reached its aim after {timeout_s:g} s")
