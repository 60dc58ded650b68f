"""The area coverage planners as missions with a common task: cover all water within bound_m of the start."""

from __future__ import annotations

import math

from uwsim.missions.heights import YoYo
from uwsim.missions.lawn_mower import mow
from uwsim.missions.lawn_mower_plan import LawnMowerPlan
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


def yoyo(
    vehicle: OwnVehicle,
    bound_m: float = 16.0,
    upper_m: float = 5.0,
    lower_m: float = 2.5,
    slope_deg: float = 12.0,
    line_spacing_m: float = 5.0,
    speed_m_s: float = 0.6,
) -> Steps[None]:
    """Mow a square ahead, bound_m long, in lanes that go down and up between two heights above the bed."""
    x, y, _ = vehicle.pose.position_world_m.tolist()
    heading = vehicle.pose.yaw_rad
    ahead, port = (math.cos(heading), math.sin(heading)), (-math.sin(heading), math.cos(heading))
    sides = ((0.5, -0.5), (1.5, -0.5), (1.5, 0.5), (0.5, 0.5))
    area_m = [[at + bound_m * (u * a + v * p) for at, a, p in zip((x, y), ahead, port, strict=True)] for u, v in sides]
    profile = YoYo(upper_m, lower_m, above_bed=True, slope_deg=slope_deg, clear_m=lower_m)
    yield from mow(vehicle, LawnMowerPlan(area_m, lower_m, line_spacing_m, speed_m_s, tilt_deg=20.0, yoyo=profile))


def _leave_station(vehicle: OwnVehicle) -> None:
    if not vehicle.released:
        vehicle.undock()
