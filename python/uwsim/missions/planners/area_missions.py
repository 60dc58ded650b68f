"""The area coverage planners as missions with a common task: cover all water within bound_m of the start."""

from __future__ import annotations

import math

from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.boustrophedon import MownArea, mow_area
from uwsim.missions.planners.frontier import Explored, explore
from uwsim.missions.planners.unknown_water import MownWater, mow_unknown_water
from uwsim.missions.steps import Steps

CORNERS = 16  # corners of the polygon that approximates the circle


def unknown_water(
    vehicle: OwnVehicle, bound_m: float = 20.0, altitude_m: float = 3.0, speed_m_s: float = 0.6
) -> Steps[MownWater]:
    """Mow with no prior knowledge other than the bound."""
    _leave_station(vehicle)
    return (yield from mow_unknown_water(vehicle, bound_m, altitude_m=altitude_m, speed_m_s=speed_m_s))


def frontier(
    vehicle: OwnVehicle, bound_m: float = 20.0, altitude_m: float = 3.0, speed_m_s: float = 0.6
) -> Steps[Explored]:
    """Explore by travelling to the frontiers of the live map."""
    _leave_station(vehicle)
    return (yield from explore(vehicle, bound_m, altitude_m=altitude_m, speed_m_s=speed_m_s))


def boustrophedon(
    vehicle: OwnVehicle, bound_m: float = 20.0, altitude_m: float = 3.0, speed_m_s: float = 0.6
) -> Steps[MownArea]:
    """Mow the circle of radius bound_m as a polygon, even if it contains land."""
    _leave_station(vehicle)
    x, y, _ = vehicle.pose.position_world_m.tolist()
    angles = [2.0 * math.pi * k / CORNERS for k in range(CORNERS)]
    area_m = [(x + bound_m * math.cos(angle), y + bound_m * math.sin(angle)) for angle in angles]
    return (yield from mow_area(vehicle, area_m, altitude_m=altitude_m, speed_m_s=speed_m_s))


def _leave_station(vehicle: OwnVehicle) -> None:
    if not vehicle.released:
        vehicle.undock()
