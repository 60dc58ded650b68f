"""Missions that end at a given place: keeping it, and returning into the dock."""

from __future__ import annotations

import math

import numpy as np

from uwsim.missions.moves import goto, hold
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.steps import Steps

CREEP_M_S = 0.2


def keep_place(
    vehicle: OwnVehicle, position_m: tuple[float, float, float] = (0.0, 0.0, -4.0), time_s: float = 90.0
) -> Steps[None]:
    """Go to a place and stay there."""
    if not vehicle.released:
        vehicle.undock()
    yield from goto(vehicle, position_m, within_m=0.3)
    yield from hold(vehicle, time_s, position_world_m=position_m)


def reach_dock(vehicle: OwnVehicle, away_m: float = 8.0, settle_s: float = 10.0) -> Steps[None]:
    """Leave the dock ahead, return to where the vehicle was docked, against the current, and stay there."""
    dock, yaw_rad = np.array(vehicle.pose.position_world_m, np.float64), vehicle.pose.yaw_rad
    vehicle.undock()
    ahead = np.array([math.cos(yaw_rad), math.sin(yaw_rad), 0.0])
    yield from goto(vehicle, dock + away_m * ahead, heading_rad=yaw_rad)
    yield from goto(vehicle, dock + 2.5 * ahead, heading_rad=yaw_rad, within_m=0.3)
    yield from goto(vehicle, dock, heading_rad=yaw_rad, speed_m_s=CREEP_M_S, within_m=0.2)
    yield from hold(vehicle, settle_s, position_world_m=dock, heading_rad=yaw_rad)
