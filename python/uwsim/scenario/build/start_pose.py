"""A vehicle's initial pose: docked at the station, or free."""

from __future__ import annotations

import numpy as np

from uwsim.scenario.build.station import dock_position, station_at_start
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle_entry import VehicleEntry


def start_pose(scenario: Scenario, vehicle: VehicleEntry) -> tuple[tuple[float, float, float], float]:
    """Return the vehicle's initial position (world, metres) and yaw (radians), docked or free."""
    if vehicle.start is not None:
        return vehicle.start.position_m, float(np.radians(vehicle.start.yaw_deg))
    station = station_at_start(scenario)
    x, y, z = dock_position(station)
    return (float(x), float(y), float(z)), float(np.radians(station.yaw_deg))
