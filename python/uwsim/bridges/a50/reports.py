"""The reports of a DVL A50: velocity and transducers, and the position by dead reckoning.

Names, units and axes are those of Water Linked's protocol json_v3.1: x forward, y right, z down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.instruments.readings import DvlReading

Floats = NDArray[np.float64]

FORMAT = "json_v3.1"
MIRROR = np.diag([1.0, -1.0, -1.0])
"""From the sensor's axes, with y to port and z up, to the A50's, and back."""
LOST_M = -1.0
WANDER_M_S2 = 0.1
"""How fast the standard deviation of the speed grows without a lock; assumed."""


def beams(parameters: dict[str, list[float]]) -> Floats:
    """Return the unit vectors of a DVL's beams (4, 3) in the A50's axes. parameters: of the sensor."""
    slant = math.radians(parameters["beam_slant_deg"][0])
    azimuths = np.radians(parameters["beam_azimuth_deg"][0] + 90.0 * np.arange(4))
    flat = math.sin(slant) * np.column_stack([np.cos(azimuths), np.sin(azimuths)])
    return np.asarray(np.column_stack([flat, np.full(4, -math.cos(slant))]) @ MIRROR)


def covariance(directions: Floats, std_m_s: float) -> Floats:
    """Return the covariance (3, 3) of the least-squares velocity of beams (n, 3) with an error each."""
    return np.asarray(std_m_s**2 * np.linalg.inv(directions.T @ directions))


def merit(velocity_covariance: Floats) -> float:
    """Return the figure of merit: the largest standard deviation in any direction, as in the protocol's example."""
    return math.sqrt(max(float(np.linalg.eigvalsh(velocity_covariance)[-1]), 0.0))


def error_m_s(noise: _core.NoiseSpec) -> float:
    """Return the standard deviation of a beam's velocity from sample to sample: noise and resolution."""
    return math.hypot(noise.std, noise.quantum / math.sqrt(12.0))


@dataclass(frozen=True)
class Measured:
    """A sample of the DVL in the A50's axes.

    velocity_m_s: (3,), 0 without a lock. covariance: (3, 3). altitude_m: along z, LOST_M without a lock. ranges_m,
    along_m_s: (4,), inf and 0 for a lost beam.
    """

    time_ns: int
    is_valid: bool
    velocity_m_s: Floats
    covariance: Floats
    altitude_m: float
    ranges_m: Floats
    along_m_s: Floats

    @classmethod
    def of(
        cls, reading: DvlReading, time_ns: int, directions: Floats, std_m_s: float, *, is_valid: bool, scale: float,
        offset_rad: float,
    ) -> Measured:  # fmt: skip
        """Convert a reading. scale: the speed of sound that is set, by the water's. offset_rad: of the mounting."""
        ranges_m = scale * np.asarray(reading.beam_ranges_m)
        seen = np.isfinite(ranges_m)
        is_valid = is_valid and int(seen.sum()) >= 3
        c, s = math.cos(offset_rad), math.sin(offset_rad)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        spread = turn @ covariance(directions[seen], std_m_s) @ turn.T if is_valid else np.zeros((3, 3))
        return cls(
            time_ns,
            is_valid,
            scale * (turn @ MIRROR @ reading.velocity_m_s) if is_valid else np.zeros(3),
            spread,
            float(np.mean(ranges_m[seen] * directions[seen, 2])) if is_valid else LOST_M,
            ranges_m,
            scale * np.asarray(reading.beam_velocities_m_s),
        )

    def report(self, since_ms: float, valid_us: int, sent_us: int) -> dict[str, Any]:
        """Return the velocity report. since_ms: since the last one. valid_us, sent_us: Unix times of ping and report.

        time_of_transmission is in simulated time, too.
        """
        return {
            "time": since_ms,
            **dict(zip(("vx", "vy", "vz"), self.velocity_m_s.tolist(), strict=True)),
            "fom": merit(self.covariance),
            "covariance": self.covariance.tolist(),
            "altitude": self.altitude_m,
            "transducers": [
                {
                    "id": k,
                    "velocity": float(self.along_m_s[k]),
                    "distance": float(range_m) if math.isfinite(range_m) else LOST_M,
                    "rssi": 0.0,
                    "nsd": 0.0,
                    "beam_valid": bool(math.isfinite(range_m)),
                }
                for k, range_m in enumerate(self.ranges_m)
            ],
            "velocity_valid": self.is_valid,
            "status": 0,
            "format": FORMAT,
            "type": "velocity",
            "time_of_validity": valid_us,
            "time_of_transmission": sent_us,
        }


class DeadReckoning:
    """The position since a reset, in the axes that the DVL had then: velocities turned by the IMU and summed up.

    Without a lock, it goes on with the last velocity, and its standard deviation grows.
    """

    def __init__(self) -> None:
        self._start: Floats | None = None
        self.reset()

    def reset(self) -> None:
        """Begin again where the DVL is."""
        self._start = None
        self._position_m, self._variance_m2 = np.zeros(3), 0.0
        self._velocity_m_s, self._error_m_s = np.zeros(3), 0.0
        self._turned = np.eye(3)
        self._time_ns = 0

    def add(self, measured: Measured, world_from_dvl: Floats) -> None:
        """Take a sample. world_from_dvl: (3, 3), the IMU's attitude of the A50's axes in the world."""
        if self._start is None:
            self._start, self._time_ns = world_from_dvl, measured.time_ns
        self._turned = self._start.T @ world_from_dvl
        elapsed_s = 1e-9 * (measured.time_ns - self._time_ns)
        self._time_ns = measured.time_ns
        if measured.is_valid:
            self._velocity_m_s, self._error_m_s = measured.velocity_m_s, merit(measured.covariance)
        else:
            self._error_m_s += WANDER_M_S2 * elapsed_s
        self._position_m = self._position_m + elapsed_s * (self._turned @ self._velocity_m_s)
        self._variance_m2 += (elapsed_s * self._error_m_s) ** 2

    def report(self, unix_s: float) -> dict[str, Any]:
        """Return the dead reckoning report."""
        turned = self._turned
        return {
            "ts": unix_s,
            **dict(zip("xyz", self._position_m.tolist(), strict=True)),
            "std": math.sqrt(self._variance_m2),
            "roll": math.degrees(math.atan2(turned[2, 1], turned[2, 2])),
            "pitch": math.degrees(math.asin(float(np.clip(-turned[2, 0], -1.0, 1.0)))),
            "yaw": math.degrees(math.atan2(turned[1, 0], turned[0, 0])),
            "type": "position_local",
            "status": 0,
            "format": FORMAT,
        }
