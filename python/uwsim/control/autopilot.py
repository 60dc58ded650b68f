"""Heading, height, velocity and level hold by efforts: a PI or PD loop for each axis (Fossen 2011, ch. 12)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from uwsim.control.protocols import SteeredVehicle

STEADY_RATE_LOOP = 0.4


@dataclass(frozen=True)
class Gains:
    """Share of full effort for each unit of error. The defaults suit vehicles that reach about 1 m/s and 0.5 rad/s."""

    speed: float = 1.5  # per m/s
    speed_integral: float = 0.6  # per m
    heading: float = 2.0  # per rad
    heading_rate: float = 1.5  # per rad/s
    height: float = 0.8  # per m
    height_rate: float = 1.2  # per m/s
    height_integral: float = 0.05  # per m s
    level: float = 2.0  # per unit of sine of the tilt
    level_rate: float = 0.5  # per rad/s


class Autopilot:
    """Turns wanted heading, horizontal velocity and height into efforts, and keeps the vehicle level.

    Call steer once a control period.
    """

    def __init__(self, vehicle: SteeredVehicle, period_s: float = 0.1, gains: Gains | None = None) -> None:
        self.vehicle = vehicle
        self.period_s = period_s
        self.gains = gains or _steady(Gains(), getattr(vehicle, "authority", None), period_s)
        self._speed_sum = np.zeros(2)
        self._height_sum = 0.0

    def steer(self, heading_rad: float, velocity_world_m_s: NDArray[np.float64], z_world_m: float) -> None:
        """One control period towards a heading, a horizontal velocity (2,) and a height (z, negative under water)."""
        gains, pose, velocity = self.gains, self.vehicle.pose, self.vehicle.velocity
        yaw = pose.yaw_rad
        cos, sin = np.cos(yaw), np.sin(yaw)
        wanted_body = np.array([[cos, sin], [-sin, cos]]) @ velocity_world_m_s
        speed_error = wanted_body - velocity.linear_body_m_s[:2]
        surge_sway = gains.speed * speed_error + self._speed_sum
        self._speed_sum = np.clip(self._speed_sum + gains.speed_integral * self.period_s * speed_error, -1.0, 1.0)

        turn = wrap_angle(heading_rad - yaw)
        yaw_effort = gains.heading * turn - gains.heading_rate * velocity.angular_body_rad_s[2]

        height_error = z_world_m - pose.position_world_m[2]
        climb = (pose.world_from_body[:3, :3] @ velocity.linear_body_m_s)[2]
        heave = gains.height * height_error - gains.height_rate * climb + self._height_sum
        step = gains.height_integral * self.period_s * np.clip(height_error, -1.0, 1.0)
        self._height_sum = float(np.clip(self._height_sum + step, -0.5, 0.5))

        # A slender vehicle's own flow noses it over (Munk's moment): turn the body's z back to the world's.
        up_body = pose.world_from_body[2, :3]
        roll = -gains.level * up_body[1] - gains.level_rate * velocity.angular_body_rad_s[0]
        pitch = gains.level * up_body[0] - gains.level_rate * velocity.angular_body_rad_s[1]

        efforts = np.clip([surge_sway[0], surge_sway[1], heave, roll, pitch, yaw_effort], -1.0, 1.0)
        self.vehicle.set_effort(*(float(effort) for effort in efforts))


def _steady(gains: Gains, authority: NDArray[np.float64] | None, period_s: float) -> Gains:
    """Gains lowered where the vehicle turns too briskly for a loop of this period; authority: see uwsim's Vehicle.

    A rate loop sampled at T is steady while rate gain x authority x T < 2; without overshoot well below 1.
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
    """The same angle in [-pi, pi)."""
    return float((angle_rad + np.pi) % (2 * np.pi) - np.pi)
