"""Failsafe manoeuvres: hold, surface, return. Each is a function of the vehicle's pose when the manoeuvre starts.

They set targets; the control loops of uwsim.navigation.control.Controller do the steering.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from uwsim.navigation.control.controller import Controller
from uwsim.scenario.spec.battery import Failsafe

PULL_1_S = 0.3  # speed towards home, per metre of distance
ARRIVED_M = 1.0
SHALLOWEST_M = 0.5  # depth above which `return` does not climb
SLOWING_M_S2 = 0.1  # deceleration at the end of an ascent; assumed to be within any vehicle's capability


@dataclass(frozen=True)
class Beginning:
    """The pose and time at which a manoeuvre began: x, y, z [m], yaw [rad], time [s]."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    time_s: float


def hold(pilot: Controller, began: Beginning) -> None:
    """Hold depth, heading and position."""
    pilot.hold((began.x_m, began.y_m, began.z_m), began.yaw_rad)


def surface(pilot: Controller, began: Beginning, figures: Failsafe, time_s: float) -> None:
    """Ascend at the configured rate, holding heading and position, and stay at the configured depth."""
    height_m = max(0.0, -figures.surface_m - began.z_m)
    risen_m, rate_m_s = ascent(height_m, figures.ascent_m_s, time_s - began.time_s)
    velocity_m_s = (0.0, 0.0, rate_m_s)
    pilot.hold((began.x_m, began.y_m, began.z_m + risen_m), began.yaw_rad, velocity_world_m_s=velocity_m_s)


def ascent(height_m: float, rate_m_s: float, since_s: float) -> tuple[float, float]:
    """Return the height gained [m] and the rate [m/s] after `since_s` seconds of an ascent of height_m.

    The rate is constant until the vehicle slows down near the end.
    """
    fastest_m_s = min(rate_m_s, math.sqrt(2.0 * SLOWING_M_S2 * height_m))
    if fastest_m_s <= 0.0:
        return 0.0, 0.0
    slowing_s = fastest_m_s / SLOWING_M_S2
    left_s = (height_m - 0.5 * fastest_m_s * slowing_s) / fastest_m_s + slowing_s - since_s
    if left_s >= slowing_s:
        return fastest_m_s * since_s, fastest_m_s
    left_s = max(0.0, left_s)
    return height_m - 0.5 * SLOWING_M_S2 * left_s**2, SLOWING_M_S2 * left_s


def fly_back(
    pilot: Controller,
    began: Beginning,
    figures: Failsafe,
    time_s: float,
    home_m: tuple[float, float, float],
    above_bed_m: float,
) -> None:
    """Ascend or descend to the return depth, turn towards home, fly there, and hold at home's depth.

    above_bed_m: the vehicle's altimeter reading; inf without an altimeter or an echo.
    """
    x_m, y_m, z_m = pilot.estimate.pose.position_world_m.tolist()
    east_m, north_m = home_m[0] - x_m, home_m[1] - y_m
    away_m = math.hypot(east_m, north_m)
    way_z_m = home_m[2] if figures.return_depth_m is None else -figures.return_depth_m
    if away_m <= ARRIVED_M:
        pilot.hold(home_m, pilot.estimate.pose.yaw_rad)
        return
    change_m = figures.ascent_m_s * (time_s - began.time_s)
    z_m = began.z_m + max(-change_m, min(change_m, way_z_m - began.z_m))
    z_m = min(max(z_m, z_m_above_bed(z_m, pilot, figures, above_bed_m)), -SHALLOWEST_M)
    is_at_depth = abs(way_z_m - began.z_m) <= change_m
    speed_m_s = min(figures.speed_m_s, PULL_1_S * away_m) if is_at_depth else 0.0
    pilot.steer(math.atan2(north_m, east_m), (speed_m_s * east_m / away_m, speed_m_s * north_m / away_m), z_m)


def z_m_above_bed(z_m: float, pilot: Controller, figures: Failsafe, above_bed_m: float) -> float:
    """Return the height (z) at which the vehicle keeps its minimum altitude above the bed."""
    if not math.isfinite(above_bed_m):
        return z_m
    return float(pilot.estimate.pose.position_world_m[2]) - above_bed_m + figures.height_m
