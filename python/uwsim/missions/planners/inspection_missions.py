"""The planners that inspect a single object, as missions for the objects in the packaged `cove` scenario."""

from __future__ import annotations

import math

from uwsim.missions.moves import goto, turn_to
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.curves import fly_through
from uwsim.missions.planners.gate import Gate, pass_gate
from uwsim.missions.planners.pipeline import PipelineTrack, follow_pipeline
from uwsim.missions.planners.wall import WallPass, scan_wall
from uwsim.missions.steps import Steps


def pipeline(vehicle: OwnVehicle, start_m: tuple[float, float] = (-19.0, -5.0)) -> Steps[PipelineTrack]:
    """Follow the pipeline from its western end."""
    _leave_station(vehicle)
    return (yield from follow_pipeline(vehicle, start_m, -0.3))


def gate(vehicle: OwnVehicle, near_m: tuple[float, float] = (-4.0, 2.0)) -> Steps[Gate]:
    """Pass through the gate eastwards."""
    _leave_station(vehicle)
    yield from goto(vehicle, (near_m[0] - 9.0, near_m[1] - 2.0), altitude_m=3.0)
    return (yield from pass_gate(vehicle, near_m, 4.0, 4.0))


def wall(vehicle: OwnVehicle, length_m: float = 5.0) -> Steps[list[WallPass]]:
    """Scan the southern face of the quay."""
    _leave_station(vehicle)
    yield from goto(vehicle, (-8.0, 11.0, -3.0), speed_m_s=0.8)
    yield from turn_to(vehicle, 0.5 * math.pi)
    return (yield from scan_wall(vehicle, length_m))


def curves(vehicle: OwnVehicle, radius_m: float = 3.0) -> Steps[object]:
    """Fly through four waypoints on a Dubins path."""
    _leave_station(vehicle)
    points = [(-8.0, -16.0), (2.0, -14.0), (2.0, -4.0), (-10.0, -4.0)]
    return (yield from fly_through(vehicle, points, altitude_m=3.0, radius_m=radius_m))


def _leave_station(vehicle: OwnVehicle) -> None:
    if not vehicle.released:
        vehicle.undock()
