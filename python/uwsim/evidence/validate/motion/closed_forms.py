"""Bodies whose motion has a closed form: a heeled box, and a tumbling body.

The native tests have the others: Craft.ASphereAcceleratesWithHalfItsDisplacedMassAdded,
Integrator.AtTerminalSpeedDragEqualsThrust, RigidBodyWorld.AFloatingBodyDisplacesItsMass and the laws of Contact.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from uwsim.base.whole_trimesh import trimesh
from uwsim.evidence.validate.check import Check, relative, within
from uwsim.evidence.validate.flights import attitude_error_rad, deep_water, fly
from uwsim.evidence.validate.motion.published import BLUEROV2_HEAVY
from uwsim.evidence.validate.motion.reference_solution import GRAVITY_M_S2, Coefficients, integrate
from uwsim.scenario import VehicleModel
from uwsim.simulator.simulator import Simulator

GROUP = "closed forms"
WATER_KG_M3 = 1000.0
ZERO_3 = (0.0, 0.0, 0.0)
ZERO_6 = (0.0,) * 6
TUMBLE = (0.3, -0.2, 0.1, 1.0, 0.8, -1.2)
TUMBLING_S = 100.0


def closed_forms() -> list[Check]:
    """Return all checks."""
    return [floating_box(), tumbling()]


STATED = ("mass_kg", "centre_of_mass_m", "inertia_kg_m2", "added_mass", "linear_damping", "quadratic_damping")


def simulator_with_body(body: Coefficients, mesh: trimesh.Trimesh, **values: object) -> Simulator:
    """Return a simulator for a vehicle with these coefficients and this hull, built like a user's vehicle.

    values: further keys of its file.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hull.obj"
        _write_obj(mesh, path)
        stated = {key: getattr(body, key) for key in STATED}
        driven = {"max_force_n": ZERO_3, "max_torque_nm": ZERO_3, "friction": 0.5, "restitution": 0.1}
        sonar = {"position_m": ZERO_3}
        model = VehicleModel.model_validate(
            {"name": "body", "mesh": path, "sonar": sonar, **stated, **driven, **values}
        )
        return deep_water(model, density_kg_m3=body.water_density_kg_m3)


def _write_obj(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a mesh at full precision; trimesh's exporters round."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces.tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def floating_box() -> Check:
    """Check the righting moment of a box with two fifths of the density of water.

    M = m g sin(heel) (GM + BM tan^2(heel) / 2), GM = BM - BG: exact while each edge stays on its side of the surface
    (Rawson and Tupper 2001, Basic Ship Theory, ch. 4).
    """
    length, beam, height, share = 2.0, 1.0, 0.4, 0.4
    hull = trimesh.creation.box((length, beam, height))
    mass = share * WATER_KG_M3 * hull.volume
    body = Coefficients(
        mass_kg=mass,
        volume_m3=hull.volume,
        inertia_kg_m2=tuple(mass / 12 * np.array([beam**2 + height**2, length**2 + height**2, length**2 + beam**2])),
        added_mass=(mass,) * 3 + (mass / 10,) * 3,
        linear_damping=(900.0, 900.0, 1500.0, 150.0, 300.0, 100.0),
        quadratic_damping=ZERO_6,
    )
    draught = share * height
    metacentric_radius = beam**2 / (12 * draught)
    metacentric_height = metacentric_radius - 0.5 * (height - draught)
    heel = np.radians(8.0)
    righting = metacentric_height + 0.5 * metacentric_radius * np.tan(heel) ** 2
    torque_nm = mass * GRAVITY_M_S2 * np.sin(heel) * righting
    # The torque of an effort is scaled by the submerged share of the hull, as a thruster's would be.
    sim = simulator_with_body(body, hull, max_torque_nm=(torque_nm / share, 0.0, 0.0))
    sim.rov.place((0.0, 0.0, 0.1))
    sim.advance(30.0)
    sim.rov.set_effort(roll=1.0)
    sim.advance(40.0)
    attitude = sim.rov.pose.world_from_body[:3, :3]
    heeled = np.arctan2(attitude[2, 1], attitude[2, 2])
    return relative(GROUP, "floating box under torque: heel", heel, heeled, 1e-5, "rad")


def tumbling() -> Check:
    """Check the attitude of a neutral, undamped BlueROV2 Heavy with r_G = r_B after 100 s by a high-order integration.

    That it keeps its energy and momentum is Integrator.ATumblingBodyInInviscidWaterConservesEnergyAndMomentum.
    """
    body = undamped_heavy()
    side = body.volume_m3 ** (1 / 3)
    flown = fly(simulator_with_body(body, trimesh.creation.box((side, side, side))), TUMBLE, TUMBLING_S)
    off_rad = attitude_error_rad(flown.attitudes, integrate(body, TUMBLE, flown.times_s).attitudes)
    return within(GROUP, f"tumbling {TUMBLING_S:g} s: attitude error", 0.0, float(off_rad.max()), 1.0, 1e-3, "rad")


def undamped_heavy() -> Coefficients:
    """Return a neutral BlueROV2 Heavy in inviscid water, with centres of mass and buoyancy at the origin."""
    return replace(
        BLUEROV2_HEAVY,
        mass_kg=WATER_KG_M3 * BLUEROV2_HEAVY.volume_m3,
        linear_damping=ZERO_6,
        quadratic_damping=ZERO_6,
        centre_of_buoyancy_m=ZERO_3,
        munk_share=1.0,
        crossflow_length_m=0.0,
    )
