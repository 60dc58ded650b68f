"""Holds a velocity in body axes: a PI loop for each axis (Fossen 2011, ch. 12)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.control.autopilot import Gains, steady_gains
from uwsim.control.protocols import SteeredVehicle
from uwsim.sealed import Sealed

Vector = NDArray[np.float64]
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


class VelocityHold(Sealed):
    """Turns a commanded velocity into efforts. Roll and pitch are kept level while no rate is commanded about them.

    Call `efforts` once in each control period. An integral stops growing while its effort is at the limit.
    """

    vehicle: SteeredVehicle
    period_s: float
    gains: Gains
    _fixed_when = "the controller is made"

    def __init__(self, vehicle: SteeredVehicle, period_s: float, gains: Gains | None = None) -> None:
        self.vehicle = vehicle
        self.period_s = period_s
        self.gains = gains or steady_gains(Gains(), getattr(vehicle, "authority", None), period_s)
        self._integrals = np.zeros(6)

    def efforts(self, velocity_body: Vector) -> dict[str, float]:
        """Return the efforts of this period for a velocity (6,), [m/s] and [rad/s]: by axis, each in [-1, 1]."""
        gains, velocity = self.gains, self.vehicle.velocity
        error = velocity_body - np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s])
        gain = np.array([gains.speed] * 3 + [gains.level_rate] * 2 + [gains.heading_rate])
        growth = self.period_s * np.array([gains.speed_integral] * 3 + [gains.level] * 2 + [gains.heading])
        up_x, up_y, _ = self.vehicle.pose.world_from_body[2, :3]
        levelling = np.array([0, 0, 0, -gains.level * up_y, gains.level * up_x, 0])
        levelling[velocity_body != 0] = 0.0

        grown = self._integrals + growth * error
        grown[3:5][velocity_body[3:5] == 0] = 0.0  # levelling holds these
        wanted = gain * error + grown + levelling
        free = np.abs(wanted) < 1.0
        self._integrals[free] = grown[free]
        limited = np.clip(gain * error + self._integrals + levelling, -1.0, 1.0)
        return dict(zip(AXES, limited.tolist(), strict=True))
