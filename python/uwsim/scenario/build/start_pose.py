"""A vehicle's start: docked at the station or free."""

from __future__ import annotations

import numpy as np

from uwsim.scenario.build.station import dock_position
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle_entry import VehicleEntry


def start_pose(scenario: Scenario, vehicle: VehicleEntry) -> tuple[tuple[float, float, float], float]:
    """Return the vehicle's origin at the start (world, metres) and its yaw (radians), docked or free."""
    if vehicle.start is not None:
        return vehicle.start.position_m, float(np.radians(vehicle.start.yaw_deg))
    x, y, z = dock_position(scenario.station)
    return (float(x), float(y), float(z)), float(np.radians(scenario.station.yaw_deg))
