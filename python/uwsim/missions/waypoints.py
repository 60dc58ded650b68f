"""Waypoints: places visited one after another, as drawn on the chart of the operator's station."""

from __future__ import annotations

from collections.abc import Sequence

from uwsim.missions.moves import Point, goto
from uwsim.missions.steps import Steps
from uwsim.missions.vehicle import Vehicle


def visit(vehicle: Vehicle, points_world_m: Sequence[Point], speed_m_s: float = 0.5) -> Steps[int]:
    """Undock if needed, then visit each point (3,) in turn and log `waypoint` with its number. Return their count."""
    if not vehicle.released:
        vehicle.undock()
    for number, point in enumerate(points_world_m, 1):
        yield from goto(vehicle, point, speed_m_s=speed_m_s)
        vehicle.log("waypoint", number=number)
    return len(points_world_m)
