"""The motor that pans and tilts a camera: each axis turns to its target angle at a finite rate in simulated time."""

from __future__ import annotations

import math
from typing import Any

from pydantic import FiniteFloat

from uwsim.base.saved_state import Nanoseconds
from uwsim.scenario.spec.camera import PanTilt

MOTORS = ("pan", "tilt")
Angles = tuple[FiniteFloat, FiniteFloat]
Motion = tuple[Nanoseconds, Angles, Angles]
"""A time [ns], the angles of the axes at that time, and their target angles."""
TOLERANCE_RAD = 1e-9  # allows for rounding in limits converted from degrees


class PanTiltHead:
    """A pan-tilt motor. Its state consists of the axis angles at some time and the target angles of the axes."""

    def __init__(self, camera: str, spec: PanTilt) -> None:
        self._camera = camera
        self._limits_rad = [tuple(map(math.radians, limits)) for limits in (spec.pan_limits_deg, spec.tilt_limits_deg)]
        self._rate_rad_s = math.radians(spec.rate_deg_s)
        self._motion: Motion = 0, (0.0, 0.0), (0.0, 0.0)

    def restart(self) -> None:
        """Return to the initial state: time 0, pointing along the mount."""
        self._motion = 0, (0.0, 0.0), (0.0, 0.0)

    def angles_rad(self, time_ns: int) -> Angles:
        """Return pan, positive to port, and tilt, positive down, at a given time."""
        since_ns, start, aim = self._motion
        if start == aim:
            return aim
        reach = self._rate_rad_s * max(time_ns - since_ns, 0) * 1e-9
        pan, tilt = (a + min(max(b - a, -reach), reach) for a, b in zip(start, aim, strict=True))
        return pan, tilt

    @property
    def target_rad(self) -> Angles:
        """The target pan and tilt."""
        return self._motion[2]

    def aim(self, time_ns: int, pan_rad: float | None, tilt_rad: float | None) -> None:
        """Turn to these angles from time_ns on; None leaves the aim of that axis unchanged.

        Raises ValueError and changes nothing if an angle is beyond the axis limits.
        """
        given = (pan_rad, tilt_rad)
        for axis, value, (low, high) in zip(MOTORS, given, self._limits_rad, strict=True):
            if value is not None and not low - TOLERANCE_RAD <= value <= high + TOLERANCE_RAD:
                raise ValueError(
                    f"camera '{self._camera}': {axis}_rad = {value:g} rad: must be in [{low:.4g}, {high:.4g}] rad"
                )
        pan, tilt = (old if new is None else new for old, new in zip(self._motion[2], given, strict=True))
        self._motion = time_ns, self.angles_rad(time_ns), (pan, tilt)

    def save(self) -> list[Any]:
        """Return the state as JSON values."""
        since_ns, start, aim = self._motion
        return [since_ns, list(start), list(aim)]

    def restore(self, motion: Motion) -> None:
        """Continue from the result of `save`."""
        self._motion = motion
