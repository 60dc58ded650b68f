"""An autopilot for heading, height, velocity and level: a PI or PD loop for each axis (Fossen 2011, ch. 12)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from uwsim.control.protocols import SteeredVehicle
from uwsim.sealed import Sealed

Vector = NDArray[np.float64]
STEADY_RATE_LOOP = 0.4  # largest rate gain x authority x period; see `steady_gains`


@dataclass(frozen=True)
class Gains:
    """Share of full effort for each unit of error. The defaults suit vehicles that reach some 1 m/s and 0.5 rad/s."""

    speed: float = 1.5  # per m/s
    speed_integral: float = 0.6  # per m
    heading: float = 2.0  # per rad
    heading_rate: float = 1.5  # per rad/s
    height: float = 0.8  # per m
    height_rate: float = 1.2  # per m/s
    height_integral: float = 0.05  # per m s
    level: float = 2.0  # per unit of sine of the tilt
    level_rate: float = 0.5  # per rad/s


class Autopilot(Sealed):
    """Turns a commanded heading, horizontal velocity and height into efforts, and keeps the vehicle level.

    Call `steer` once in each control period. `gains` may be replaced at any time.
    """

    vehicle: SteeredVehicle
    period_s: float
    _fixed_when = "the autopilot is made"

    def __init__(self, vehicle: SteeredVehicle, period_s: float = 0.1, gains: Gains | None = None) -> None:
        self.vehicle = vehicle
        self.period_s = period_s
        self._gains = gains or steady_gains(Gains(), getattr(vehicle, "authority", None), period_s)
        self._surge_integral = self._sway_integral = self._height_integral = 0.0

    @property
    def gains(self) -> Gains:
        """The gains of the next control period on."""
        return self._gains

    @gains.setter
    def gains(self, gains: Gains) -> None:
        self._gains = gains

    def steer(self, heading_rad: float, velocity_world_m_s: Sequence[float] | Vector, z_world_m: float) -> None:
        """Set the efforts of one control period for a heading, a horizontal velocity (2,) and a height z."""
        gains, pose, velocity = self._gains, self.vehicle.pose, self.vehicle.velocity
        # Plain numbers: for arrays of three, NumPy's overhead is many times their arithmetic.
        surge_m_s, sway_m_s, heave_m_s = velocity.linear_body_m_s.tolist()
        roll_rad_s, pitch_rad_s, yaw_rad_s = velocity.angular_body_rad_s.tolist()
        up_x, up_y, up_z = pose.world_from_body[2, :3].tolist()
        east_m_s, north_m_s = float(velocity_world_m_s[0]), float(velocity_world_m_s[1])
        yaw_rad = pose.yaw_rad
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)

        surge_error = cos * east_m_s + sin * north_m_s - surge_m_s
        sway_error = cos * north_m_s - sin * east_m_s - sway_m_s
        surge = gains.speed * surge_error + self._surge_integral
        sway = gains.speed * sway_error + self._sway_integral
        share = gains.speed_integral * self.period_s
        self._surge_integral = _clip(self._surge_integral + share * surge_error, 1.0)
        self._sway_integral = _clip(self._sway_integral + share * sway_error, 1.0)

        yaw = gains.heading * wrap_angle(heading_rad - yaw_rad) - gains.heading_rate * yaw_rad_s

        height_error = float(z_world_m - pose.position_world_m[2])
        climb_m_s = up_x * surge_m_s + up_y * sway_m_s + up_z * heave_m_s
        heave = gains.height * height_error - gains.height_rate * climb_m_s + self._height_integral
        step = gains.height_integral * self.period_s * _clip(height_error, 1.0)
        self._height_integral = _clip(self._height_integral + step, 0.5)

        # The Munk moment noses a slender vehicle over: turn the body's z back to the world's.
        roll = -gains.level * up_y - gains.level_rate * roll_rad_s
        pitch = gains.level * up_x - gains.level_rate * pitch_rad_s

        wanted = (surge, sway, heave, roll, pitch, yaw)
        self.vehicle.set_effort(*[-1.0 if e < -1.0 else 1.0 if e > 1.0 else e for e in wanted])

    @property
    def integrals(self) -> tuple[float, float, float]:
        """The integrals of surge, sway and height, in effort: the only state that one period leaves to the next."""
        return self._surge_integral, self._sway_integral, self._height_integral

    @integrals.setter
    def integrals(self, integrals: tuple[float, float, float]) -> None:
        self._surge_integral, self._sway_integral, self._height_integral = integrals


def steady_gains(gains: Gains, authority: Vector | None, period_s: float) -> Gains:
    """Lower the gains if the vehicle turns too fast for a loop of this period; authority: see uwsim.vehicle.Vehicle.

    A rate loop sampled at T is stable if rate gain x authority x T < 2, and does not overshoot well below 1.
    """
    if authority is None:
        return gains

    def share(rate_gain: float, turn_rad_s2: float) -> float:
        return min(1.0, STEADY_RATE_LOOP / max(rate_gain * turn_rad_s2 * period_s, 1e-9))

    yaw = share(gains.heading_rate, float(authority[5]))
    level = share(gains.level_rate, float(max(authority[3:5])))
    return replace(
        gains,
        heading=yaw * gains.heading,
        heading_rate=yaw * gains.heading_rate,
        level=level * gains.level,
        level_rate=level * gains.level_rate,
    )


def wrap_angle(angle_rad: float) -> float:
    """Return the same angle in [-pi, pi)."""
    return float((angle_rad + math.pi) % (2 * math.pi) - math.pi)


def _clip(value: float, most: float) -> float:
    return -most if value < -most else most if value > most else value  # faster than min and max
