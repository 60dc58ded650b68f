"""The manoeuvres of a failsafe: hold, surface, return. Each is a function of where the vehicle was when it began.

The autopilot's loops (uwsim.control) do the steering; here is where to. A place is held by a velocity towards it,
proportional to the distance (a cascade, position over velocity: Fossen 2011, ch. 12).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from uwsim.control.autopilot import Autopilot
from uwsim.scenario.spec.failsafe import Failsafe

PULL_1_S = 0.3  # velocity towards a place, per metre
HOLD_M_S = 0.5  # and at most, while a place is held
ARRIVED_M = 1.0
SHALLOWEST_M = 0.5  # depth above which `return` does not climb


@dataclass(frozen=True)
class Beginning:
    """Where and when a manoeuvre began: x, y, z [m], yaw [rad], time [s]."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    time_s: float


def hold(pilot: Autopilot, began: Beginning) -> None:
    """Keep depth, heading and place."""
    pilot.steer(began.yaw_rad, _towards(pilot, began.x_m, began.y_m, HOLD_M_S), began.z_m)


def surface(pilot: Autopilot, began: Beginning, figures: Failsafe, time_s: float) -> None:
    """Ascend at the stated rate, keeping heading and place, and stay at the stated depth."""
    z_m = max(began.z_m, min(began.z_m + figures.ascent_m_s * (time_s - began.time_s), -figures.surface_m))
    pilot.steer(began.yaw_rad, _towards(pilot, began.x_m, began.y_m, HOLD_M_S), z_m)


def fly_back(
    pilot: Autopilot,
    began: Beginning,
    figures: Failsafe,
    time_s: float,
    home_m: tuple[float, float, float],
    above_bed_m: float,
) -> None:
    """Climb or sink to the way's depth, face home, fly there, and hold there at home's depth.

    above_bed_m: as the vehicle's altimeter has it; inf without one, or without an echo.
    """
    x_m, y_m, z_m = pilot.vehicle.pose.position_world_m.tolist()
    east_m, north_m = home_m[0] - x_m, home_m[1] - y_m
    away_m = math.hypot(east_m, north_m)
    way_z_m = home_m[2] if figures.return_depth_m is None else -figures.return_depth_m
    if away_m <= ARRIVED_M:
        pilot.steer(pilot.vehicle.pose.yaw_rad, _towards(pilot, home_m[0], home_m[1], HOLD_M_S), home_m[2])
        return
    change_m = figures.ascent_m_s * (time_s - began.time_s)
    z_m = began.z_m + max(-change_m, min(change_m, way_z_m - began.z_m))
    z_m = min(max(z_m, z_m_above_bed(z_m, pilot, figures, above_bed_m)), -SHALLOWEST_M)
    is_at_depth = abs(way_z_m - began.z_m) <= change_m
    speed_m_s = min(figures.speed_m_s, PULL_1_S * away_m) if is_at_depth else 0.0
    pilot.steer(math.atan2(north_m, east_m), (speed_m_s * east_m / away_m, speed_m_s * north_m / away_m), z_m)


def z_m_above_bed(z_m: float, pilot: Autopilot, figures: Failsafe, above_bed_m: float) -> float:
    """Return the height at which the vehicle is as far above the bed as it must be."""
    if not math.isfinite(above_bed_m):
        return z_m
    return float(pilot.vehicle.pose.position_world_m[2]) - above_bed_m + figures.height_m


def _towards(pilot: Autopilot, x_m: float, y_m: float, most_m_s: float) -> tuple[float, float]:
    """Return the velocity towards a place."""
    here_x_m, here_y_m, _ = pilot.vehicle.pose.position_world_m.tolist()
    east_m_s, north_m_s = PULL_1_S * (x_m - here_x_m), PULL_1_S * (y_m - here_y_m)
    share = min(1.0, most_m_s / max(math.hypot(east_m_s, north_m_s), 1e-9))
    return share * east_m_s, share * north_m_s
