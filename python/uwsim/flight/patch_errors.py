"""Errors of installation for calibration (a patch test): `--raw FILE --offsets roll=0.5,latency=0.02`.

The head is mounted as the vehicle's file states; the raw file is written as by a survey that assumes another mount, or
positions that arrive late. Software that calibrates must find the values given: roll, pitch and heading [deg] are
the true angle minus the assumed one (starboard down, bow up, clockwise), latency [s] is the age of a position,
and of its depth, that the survey takes for new.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from uwsim.base.named_numbers import named_numbers

Array = NDArray[np.float64]
LIMITS = {
    "roll": (-10.0, 10.0, "deg"), "pitch": (-10.0, 10.0, "deg"), "heading": (-10.0, 10.0, "deg"),
    "latency": (0.0, 2.0, "s"),
}  # fmt: skip
HISTORY = 256  # pings; 2 s at any ping rate of an echo sounder


@dataclass(frozen=True)
class PatchErrors:
    """The errors; see the module."""

    roll: float = 0.0
    pitch: float = 0.0
    heading: float = 0.0
    latency: float = 0.0

    @classmethod
    def parse(cls, text: str) -> PatchErrors:
        """Return the errors in a text such as roll=0.5,latency=0.02. Raises ValueError, which names the key."""
        return cls(**named_numbers("--offsets", text, LIMITS))

    def __str__(self) -> str:
        units = {field.name: LIMITS[field.name][2] for field in fields(self)}
        return ", ".join(
            f"{name} {getattr(self, name):g} {unit}" for name, unit in units.items() if getattr(self, name)
        )

    @property
    def assumed_from_true(self) -> Array:
        """The rotation (3, 3), body axes, from the head's true orientation to the one that the survey assumes."""
        roll, pitch, yaw = np.radians([self.roll, -self.pitch, -self.heading])
        cx, sx, cy, sy, cz, sz = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
        true_from_assumed = (
            np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
            @ np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
            @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
        )
        return np.asarray(true_from_assumed.T, np.float64)


class ErringPoses:
    """Applies the errors to the poses of consecutive pings."""

    def __init__(self, errors: PatchErrors) -> None:
        self._errors, self._turn = errors, errors.assumed_from_true
        self._past: deque[tuple[float, Array]] = deque(maxlen=HISTORY)

    def assumed(self, time_s: float, body: Array, sonar: Array) -> tuple[Array, Array]:
        """Return the poses (4, 4) of body and sonar that the survey assumes at the time of a ping.

        Positions between pings are interpolated; before the first ping, the vehicle is taken to rest.
        """
        self._past.append((time_s, body[:3, 3].copy()))
        times = np.array([each[0] for each in self._past])
        places = np.array([each[1] for each in self._past])
        late = np.array([np.interp(time_s - self._errors.latency, times, axis) for axis in places.T])
        seen = body.copy()
        seen[:3, 3] = late
        mount = np.linalg.inv(body) @ sonar
        mount[:3, :3] = self._turn @ mount[:3, :3]
        return seen, seen @ mount
