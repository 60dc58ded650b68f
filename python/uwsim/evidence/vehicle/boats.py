"""A boat as it floats at rest: its metacentres and its trim."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.evidence.validate.flights import deep_scenario
from uwsim.evidence.vehicle.afloat import afloat
from uwsim.scenario.spec.vehicle import Trim, VehicleModel
from uwsim.simulator.simulator import Simulator

TILT_DEG = 0.5


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
    down_nm, over_nm = moments_nm(0.0, 0.0)
    nose_down = math.degrees(down_nm / (weight_n * pitch_m)) if pitch_m > 0.0 else 0.0
    roll = math.degrees(over_nm / (weight_n * roll_m)) if roll_m > 0.0 else 0.0
    return Boat(roll_m, pitch_m, nose_down, roll)
