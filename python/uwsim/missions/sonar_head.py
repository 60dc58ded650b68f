"""Helpers that wait for a sonar head to reach its tilt."""

from __future__ import annotations

import math
from typing import Any

from uwsim.missions.steps import Steps, until

TOLERANCE_RAD = math.radians(0.5)
TIMEOUT_S = 60.0


def is_at(sonar: Any, elevation_rad: float) -> bool:
    """Return whether the head has reached an elevation; always True for a sonar that does not report its elevation."""
    return bool(abs(getattr(sonar, "elevation_rad", elevation_rad) - elevation_rad) <= TOLERANCE_RAD)


def until_at(sonar: Any, elevation_rad: float) -> Steps[bool]:
    """Wait on the spot until the head reaches an elevation; return False on timeout."""
    return until(lambda: is_at(sonar, elevation_rad), timeout_s=TIMEOUT_S)
