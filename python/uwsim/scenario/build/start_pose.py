"""A vehicle's start: docked at the station or free."""

from __future__ import annotations

import numpy as np

from uwsim.scenario.build.station import world_from_station
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle_entry import VehicleEntry


def start_pose(scenario: Scenario, vehicle: VehicleEntry) -> tuple[tuple[float, float, float], float]:
    """The vehicle's origin at the start (world, metres) and its yaw (radians), whether docked or free."""
    if vehicle.start is not None:
        return vehicle.start.position_m, float(np.radians(vehicle.start.yaw_deg))
    station = scenario.station
    x, y, z = world_from_station(station).apply(station.dock_m) + np.asarray(station.position_m)
    return (float(x), float(y), float(z)), float(np.radians(station.yaw_deg))
