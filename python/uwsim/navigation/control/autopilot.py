"""An autopilot for heading, height, velocity and attitude: a PI or PD loop for each axis (Fossen 2011, ch. 12)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.sealed import Sealed
from uwsim.navigation.control.protocols import SteeredVehicle

STEADY_RATE_LOOP = 0.4  # maximum of rate gain x authority x period; see `steady_gains`


@dataclass(frozen=True)
class Gains:
    """Fraction of full effort per unit of error. The defaults suit vehicles that reach about 1 m/s and 0.5 rad/s."""

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
    """Converts a commanded heading, horizontal velocity and height to efforts, and keeps the vehicle level.

    Call `steer` once per control period. `gains` may be replaced at any time.
    """

    vehicle: SteeredVehicle
    period_s: float
    _fixed_when = "the autopilot is made"

    def __init__(self, vehicle: SteeredVehicle, period_s: float = 0.1, gains: Gains | None = None) -> None:
        self.vehicle = vehicle
        self.period_s = period_s
        self._gains = gains or steady_gains(Gains(), getattr(vehicle, "authority", None), period_s)
        self._core = _core.Autopilot(period_s, _core.AutopilotGains(**asdict(self._gains)))
        driven = getattr(vehicle, "controllable", AXES)
        self._idle = tuple(k for k, axis in enumerate(AXES) if axis not in driven)

    def __repr__(self) -> str:
        return f"<Autopilot of {self.vehicle!r}, every {self.period_s:g} s>"

    @property
    def gains(self) -> Gains:
        """The gains used from the next control period onwards."""
        return self._gains

    @gains.setter
    def gains(self, gains: Gains) -> None:
        self._gains = gains
        self._core.gains = _core.AutopilotGains(**asdict(gains))

    def steer(self, heading_rad: float, velocity_world_m_s: Sequence[float] | Floats, z_world_m: float) -> None:
        """Set the efforts for one control period from a heading, a horizontal velocity (2,) and a height z."""
        vehicle = self.vehicle
        efforts = self._core.steer(vehicle.pose, vehicle.velocity, heading_rad, velocity_world_m_s, z_world_m)
        if self._idle:  # the core computes roll and pitch efforts even for vehicles that cannot apply them
            efforts = tuple(0.0 if k in self._idle else effort for k, effort in enumerate(efforts))  # type: ignore[assignment]
        vehicle.set_effort(*efforts)

    @property
    def integrals(self) -> tuple[float, float, float]:
        """The integrals for surge, sway and height, in units of effort. No other state is kept between periods."""
        surge, sway, height = self._core.integrals.tolist()
        return surge, sway, height

    @integrals.setter
    def integrals(self, integrals: tuple[float, float, float]) -> None:
        self._core.integrals = np.array(integrals)


def steady_gains(gains: Gains, authority: Floats | None, period_s: float) -> Gains:
    """Return reduced gains if the vehicle turns too fast for a loop with this period. authority: see Vehicle.

    A rate loop sampled with period T is stable if rate gain x authority x T < 2, and does not overshoot well below 1.
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
    """Return the angle wrapped to [-pi, pi)."""
    return float((angle_rad + math.pi) % (2 * math.pi) - math.pi)
