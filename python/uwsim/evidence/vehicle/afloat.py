"""A vehicle at the surface: how deep it floats upright, and a boat's metacentres and trim."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.evidence.validate.flights import deep_scenario
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.spec.vehicle import Trim, VehicleModel
from uwsim.simulator.forces import WetTriangles
from uwsim.simulator.simulator import Simulator

HALVINGS = 50
TILT_DEG = 0.5


class Afloat(NamedTuple):
    """wet: the triangles that are under water. water_z_m: height of the surface above the body's origin.

    floats: whether their push balances the weight; otherwise half of the hull's height is under water.
    """

    wet: WetTriangles
    water_z_m: float
    floats: bool


def afloat(sim: Simulator) -> Afloat:
    """Put the first vehicle of a simulator in open water upright where it floats, at rest; it is left there."""
    rov = sim.rov
    heights_m = vehicle_hull(sim.scenario.vehicles[0].model)[0][:, 2]
    low_m, high_m = float(heights_m.min()), float(heights_m.max())
    weight_n = -float(rov.forces["weight"].force_body_n[2])

    def at(water_z_m: float) -> WetTriangles:
        rov.place([0.0, 0.0, -water_z_m])
        return rov.wet_triangles()

    def push_n(wet: WetTriangles) -> float:
        return float(wet.forces_body_n[:, 2].sum())

    if push_n(at(high_m)) <= weight_n * (1 + 1e-9):
        half_m = 0.5 * (low_m + high_m)
        return Afloat(at(half_m), half_m, False)
    for _ in range(HALVINGS):
        middle_m = 0.5 * (low_m + high_m)
        low_m, high_m = (low_m, middle_m) if push_n(at(middle_m)) > weight_n else (middle_m, high_m)
    return Afloat(at(high_m), high_m, True)


class Boat(NamedTuple):
    """roll_m, pitch_m: heights of the metacentres above the centre of mass. The angles: its trim, for small ones."""

    roll_m: float
    pitch_m: float
    nose_down_deg: float
    roll_to_starboard_deg: float


def boat_at_rest(model: VehicleModel, density_kg_m3: float, trim: Trim | None) -> Boat:
    """Return a boat's metacentric heights GM: its righting moment is weight times GM times a small angle.

    They are measured: the moment of buoyancy and weight about the origin, tilted by TILT_DEG either way.
    """
    sim = Simulator(deep_scenario(model, density_kg_m3=density_kg_m3, trim=trim))
    level_m = -afloat(sim).water_z_m

    def moments_nm(pitch_deg: float, roll_deg: float) -> tuple[float, float]:
        """Return the moments that turn the nose down and the hull to starboard."""
        sim.rov.place((0.0, 0.0, level_m), of_yaw_pitch_roll_deg((0.0, pitch_deg, roll_deg)))
        forces = sim.rov.forces
        total_nm = forces["weight"].torque_body_nm + forces["buoyancy"].torque_body_nm
        return float(total_nm[1]), float(total_nm[0])

    weight_n = float(np.linalg.norm(sim.rov.forces["weight"].force_body_n))
    turn = 2.0 * math.radians(TILT_DEG) * weight_n
    pitch_m = (moments_nm(-TILT_DEG, 0.0)[0] - moments_nm(TILT_DEG, 0.0)[0]) / turn
    roll_m = (moments_nm(0.0, -TILT_DEG)[1] - moments_nm(0.0, TILT_DEG)[1]) / turn
    leans = zip(moments_nm(0.0, 0.0), (pitch_m, roll_m), strict=True)
    return Boat(roll_m, pitch_m, *(math.degrees(nm / (weight_n * gm_m)) if gm_m > 0.0 else 0.0 for nm, gm_m in leans))
