"""Compares a rigid body that swings about its centre of buoyancy with MuJoCo's Runge-Kutta solution.

The body is neutral, without added mass or damping, and its centre of mass is below and beside its centre of buoyancy.
It starts with a spin about all axes, so that it tumbles and swings. In MuJoCo its buoyancy is an applied force.
"""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.whole_trimesh import trimesh
from uwsim.evidence.validate.check import Check, along, within
from uwsim.evidence.validate.flights import attitude_error_rad, fly
from uwsim.evidence.validate.motion.closed_forms import TUMBLE, ZERO_6, simulator_with_body, undamped_heavy
from uwsim.evidence.validate.motion.reference_solution import GRAVITY_M_S2, Coefficients
from uwsim.evidence.validate.peers import group

CENTRE_OF_MASS_M = (0.01, -0.005, -0.02)
DURATION_S, STEP_S = 20.0, 2e-3


def checks() -> list[Check]:
    """Return the checks of attitude and height."""
    body = replace(undamped_heavy(), added_mass=ZERO_6, centre_of_mass_m=CENTRE_OF_MASS_M)
    side = body.volume_m3 ** (1 / 3)
    flown = fly(simulator_with_body(body, trimesh.creation.box((side, side, side))), TUMBLE, DURATION_S)
    attitudes, positions_m = _by_mujoco(body, flown.times_s)
    turned_rad = float(attitude_error_rad(flown.attitudes, attitudes).max())
    name = group("rigid_body")
    return [
        within(name, f"a body swings for {DURATION_S:g} s: attitude error", 0.0, turned_rad, 1.0, 1e-6, "rad"),
        along(name, "its height", positions_m[:, 2], flown.positions_m[:, 2], 1.0, 1e-6, "m"),
        along(name, "its position along x", positions_m[:, 0], flown.positions_m[:, 0], 1.0, 1e-6, "m"),
    ]


def _by_mujoco(body: Coefficients, times_s: Floats) -> tuple[Floats, Floats]:
    """Return attitudes (n, 3, 3) and positions (n, 3) of the body's origin."""
    centre, inertia = (" ".join(map(repr, map(float, v))) for v in (body.centre_of_mass_m, body.inertia_kg_m2))
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option integrator="RK4" timestep="{STEP_S}" gravity="0 0 {-GRAVITY_M_S2}"/><worldbody>
        <body name="body"><freejoint/><inertial pos="{centre}" mass="{body.mass_kg!r}" diaginertia="{inertia}"/></body>
        </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qvel[:] = TUMBLE  # a free joint's linear velocity is in the world, its angular velocity in the body
    data.qfrc_applied[2] = body.mass_kg * GRAVITY_M_S2  # in the world, at the body's origin
    attitudes, positions_m = [], []
    for time_s in times_s:
        while data.time < time_s - STEP_S / 2:
            mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        attitudes.append(data.xmat[1].reshape(3, 3).copy())
        positions_m.append(data.xpos[1].copy())
    return np.array(attitudes), np.array(positions_m)
