"""Checks of bodies whose motion has a closed form: spheres, a box, and a tumbling body."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from uwsim.base.whole_trimesh import trimesh
from uwsim.evidence.validate.check import Check, along, relative, within
from uwsim.evidence.validate.flights import attitude_error_rad, deep_water, fly
from uwsim.evidence.validate.published import BLUEROV2_HEAVY
from uwsim.evidence.validate.reference_solution import GRAVITY_M_S2, Array, Coefficients, Flight, integrate
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
    return [*sphere_from_rest(), *terminal_speed(), *floating_box(), *tumbling()]


def simulator_with_body(
    body: Coefficients,
    mesh: trimesh.Trimesh,
    *,
    max_force_n: Sequence[float] = ZERO_3,
    max_torque_nm: Sequence[float] = ZERO_3,
    friction: float = 0.5,
    restitution: float = 0.1,
) -> Simulator:
    """Return a simulator for a vehicle with these coefficients and this hull, built like a user's vehicle."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hull.obj"
        _write_obj(mesh, path)
        model = VehicleModel.model_validate(
            {
                "name": "body",
                "mesh": path,
                "mass_kg": body.mass_kg,
                "centre_of_mass_m": body.centre_of_mass_m,
                "inertia_kg_m2": body.inertia_kg_m2,
                "added_mass": body.added_mass,
                "linear_damping": body.linear_damping,
                "quadratic_damping": body.quadratic_damping,
                "max_force_n": tuple(max_force_n),
                "max_torque_nm": tuple(max_torque_nm),
                "friction": friction,
                "restitution": restitution,
                "sonar": {"position_m": ZERO_3},
            }
        )
        return deep_water(model, density_kg_m3=body.water_density_kg_m3)


def _write_obj(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a mesh at full precision; trimesh's exporters round."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces.tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def sphere_from_rest() -> list[Check]:
    """Check that a sphere released from rest accelerates as if it carried along half of the water that it displaces.

    Lamb 1932, art. 92.
    """
    sim, body = _sphere(density_kg_m3=2000.0, quadratic_damping=0.0)
    got = _first_acceleration(sim)
    displaced = WATER_KG_M3 * body.volume_m3
    expected = -(body.mass_kg - displaced) * GRAVITY_M_S2 / (body.mass_kg + 0.5 * displaced)
    return [relative(GROUP, "sphere from rest: acceleration", expected, got, 1e-9, "m/s2")]


def terminal_speed() -> list[Check]:
    """Check terminal speeds: the drag equals the weight in water (falling sphere) or the force (driven sphere)."""
    sim, body = _sphere(density_kg_m3=2000.0, quadratic_damping=50.0)
    weight_n = (body.mass_kg - WATER_KG_M3 * body.volume_m3) * GRAVITY_M_S2
    fallen = fly(sim, ZERO_6, 20.0).velocities[-1, 2]
    ahead, _ = _sphere(density_kg_m3=1000.0, quadratic_damping=50.0, max_force_n=(40.0, 30.0, 20.0))
    ahead.rov.set_effort(surge=0.5)
    reached = fly(ahead, ZERO_6, 60.0).velocities[-1, 0]
    return [
        relative(GROUP, "sphere falling: terminal speed", np.sqrt(weight_n / 50.0), -fallen, 1e-3, "m/s"),
        relative(GROUP, "sphere driven: terminal speed", np.sqrt(20.0 / 50.0), reached, 1e-3, "m/s"),
    ]


def floating_box() -> list[Check]:
    """Check the draught and righting moment of a box with two fifths of the density of water.

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
    afloat_m = sim.rov.pose.position_world_m[2]
    sim.rov.set_effort(roll=1.0)
    sim.advance(40.0)
    attitude = sim.rov.pose.world_from_body[:3, :3]
    heeled = np.arctan2(attitude[2, 1], attitude[2, 2])
    return [
        relative(GROUP, "floating box: height of its centre", 0.5 * height - draught, afloat_m, 1e-6, "m"),
        relative(GROUP, "floating box under torque: heel", heel, heeled, 1e-5, "rad"),
    ]


def tumbling() -> list[Check]:
    """Check that a neutral, undamped BlueROV2 Heavy with r_G = r_B conserves the constants of motion for 100 s.

    Energy, |P|^2 and P.L are constants of Kirchhoff's equations; the attitude is compared with a high-order
    integration.
    """
    body = undamped_heavy()
    side = body.volume_m3 ** (1 / 3)
    sim = simulator_with_body(body, trimesh.creation.box((side, side, side)))
    flown = fly(sim, TUMBLE, TUMBLING_S)
    expected = integrate(body, TUMBLE, flown.times_s)
    checks = [
        along(GROUP, f"tumbling {TUMBLING_S:g} s: {name}", np.full_like(kept, kept[0]), kept, abs(kept[0]), 1e-3, unit)
        for name, kept, unit in constants_of_motion(body, flown)
    ]
    worst = float(attitude_error_rad(flown.attitudes, expected.attitudes).max())
    checks.append(within(GROUP, f"tumbling {TUMBLING_S:g} s: attitude error", 0.0, worst, 1.0, 1e-3, "rad"))
    return checks


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


def constants_of_motion(body: Coefficients, flight: Flight) -> list[tuple[str, Array, str]]:
    """Return energy, |P|^2 and P.L along a flight as (name, values (n,), unit)."""
    momenta = flight.velocities @ body.mass
    linear, angular = momenta[:, :3], momenta[:, 3:]
    return [
        ("energy", 0.5 * np.einsum("ni,ni->n", flight.velocities, momenta), "J"),
        ("|P|^2", np.einsum("ni,ni->n", linear, linear), "N2 s2"),
        ("P.L", np.einsum("ni,ni->n", linear, angular), "N2 m s2"),
    ]


def _sphere(
    *, density_kg_m3: float, quadratic_damping: float, max_force_n: Sequence[float] = ZERO_3
) -> tuple[Simulator, Coefficients]:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.3)
    mass, displaced = density_kg_m3 * ball.volume, WATER_KG_M3 * ball.volume
    inertia = 0.4 * mass * 0.3**2
    body = Coefficients(
        mass_kg=mass,
        volume_m3=ball.volume,
        inertia_kg_m2=(inertia,) * 3,
        added_mass=(0.5 * displaced,) * 3 + (0.0,) * 3,
        linear_damping=ZERO_6,
        quadratic_damping=(quadratic_damping,) * 6,
    )
    return simulator_with_body(body, ball, max_force_n=max_force_n), body


def _first_acceleration(sim: Simulator) -> float:
    """Return the mean vertical acceleration over the first step from rest [m/s2]."""
    sim.rov.place((0.0, 0.0, -400.0))
    sim.step()
    return float(sim.rov.velocity.linear_body_m_s[2] / sim.step_s)
