"""Checks contact with the bed: impulses with the full mass matrix, energy that never increases, and rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim.base.whole_trimesh import trimesh
from uwsim.evidence.validate.check import Check, relative, within
from uwsim.evidence.validate.closed_forms import ZERO_6, simulator_with_body
from uwsim.evidence.validate.flights import BED_DEPTH_M
from uwsim.evidence.validate.reference_solution import GRAVITY_M_S2, Array, Coefficients
from uwsim.simulator.simulator import Simulator

GROUP = "contact"
SIZE_M = (1.2, 0.8, 0.6)
ADDED_MASS = (300.0, 2000.0, 4000.0, 150.0, 250.0, 500.0)
SPEED_M_S = 1.0
REST_GAP_M = 1e-3  # maximum gap between a resting body and the bed


def contact_laws() -> list[Check]:
    """Return all checks."""
    return [*impulses(), *energy(), *rest()]


def impulses() -> list[Check]:
    """Check impulses on a face, an edge and a corner: J = (1 + e) v / (n^T M^-1 n), where M includes added mass."""
    checks = []
    for name, pitch, roll in (("face", 0.0, 0.0), ("edge", 0.3, 0.0), ("corner", 0.3, 0.25)):
        for restitution in (0.0, 0.5):
            expected, got = _impulse(pitch, roll, restitution)
            checks.append(relative(GROUP, f"impulse on {name}, e = {restitution:g}", expected, got, 0.01, "N s"))
    return checks


def energy() -> list[Check]:
    """Check that a tumbling body, whose added mass in heave is ten times its mass, never gains energy on the bed."""
    body = _body(density_kg_m3=1500.0, added_mass=(300.0, 3000.0, 8600.0, 100.0, 250.0, 400.0))
    sim = simulator_with_body(body, trimesh.creation.box(SIZE_M), restitution=0.5)
    weight_n = (body.mass_kg - 1000.0 * body.volume_m3) * GRAVITY_M_S2

    def energy_j() -> float:
        nu = _velocity(sim)
        return float(0.5 * nu @ body.mass @ nu + weight_n * (sim.rov.pose.position_world_m[2] + BED_DEPTH_M))

    sim.rov.place((0, 0, -BED_DEPTH_M + 1.5), velocity_body=(1.5, 0.4, -1.0, 0.6, -0.5, 0.8))
    start = least = energy_j()
    grown = 0.0
    for _ in range(2000):
        sim.step()
        now = energy_j()
        grown, least = max(grown, now - least), min(least, now)
    if not sim.rov.collisions:
        grown = np.inf  # no contact occurred, so nothing was tested
    return [within(GROUP, "energy gained over 10 s of striking", 0.0, grown, start, 1e-4, "J")]


def rest() -> list[Check]:
    """Check that a sinking body comes to rest within a millimetre of the bed, whatever its added mass."""
    checks = []
    for factor in (0.0, 10.0):
        body = _body(
            density_kg_m3=2000.0, added_mass=(factor * 2000.0 * float(np.prod(SIZE_M)),) * 3 + (factor * 100.0,) * 3
        )
        body_damped = simulator_with_body(_damped(body), trimesh.creation.box(SIZE_M))
        body_damped.rov.place((0.3, 0.2, -BED_DEPTH_M + 0.6))
        body_damped.advance(20.0)
        gap_m = body_damped.rov.pose.position_world_m[2] + BED_DEPTH_M - SIZE_M[2] / 2
        speed = float(np.linalg.norm(_velocity(body_damped)))
        label = f"at rest, M_A = {factor:g} M"
        checks.append(within(GROUP, f"{label}: gap", 0.5 * REST_GAP_M, gap_m, REST_GAP_M, 0.6, "m"))
        checks.append(within(GROUP, f"{label}: speed", 0.0, speed, 1.0, 1e-4, "m/s"))
    return checks


def _body(density_kg_m3: float, added_mass: tuple[float, ...]) -> Coefficients:
    x, y, z = SIZE_M
    mass = density_kg_m3 * x * y * z
    return Coefficients(
        mass_kg=mass,
        volume_m3=x * y * z,
        inertia_kg_m2=(mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z), mass / 12 * (x * x + y * y)),
        added_mass=added_mass,
        linear_damping=ZERO_6,
        quadratic_damping=ZERO_6,
    )


def _damped(body: Coefficients) -> Coefficients:
    return replace(body, linear_damping=(50.0, 50.0, 50.0, 20.0, 20.0, 20.0))


def _impulse(pitch_rad: float, roll_rad: float, restitution: float) -> tuple[float, float]:
    """Return the expected and simulated impulses of a box that moves down and strikes the bed with its lowest point."""
    body = _body(density_kg_m3=1000.0, added_mass=ADDED_MASS)
    sim = simulator_with_body(body, trimesh.creation.box(SIZE_M), friction=0.0, restitution=restitution)
    turn = Rotation.from_euler("yx", [pitch_rad, roll_rad])
    normal = turn.inv().apply([0.0, 0.0, 1.0])
    lowest = -np.sign(np.where(np.abs(normal) < 1e-12, 0.0, normal)) * np.array(SIZE_M) / 2
    direction = np.concatenate([normal, np.cross(lowest, normal)])
    height_m = float(-turn.apply(lowest)[2]) + 0.02
    down = turn.inv().apply([0.0, 0.0, -SPEED_M_S])
    sim.rov.place((0, 0, -BED_DEPTH_M + height_m), turn.as_quat(), np.concatenate([down, np.zeros(3)]))
    before = _velocity(sim)
    for _ in range(20):
        before = _velocity(sim)
        sim.step()
        if sim.rov.collisions:
            break
    expected = -(1 + restitution) * (direction @ before) / (direction @ np.linalg.solve(body.mass, direction))
    got = (body.mass @ (_velocity(sim) - before))[:3] @ normal
    return float(expected), float(got)


def _velocity(sim: Simulator) -> Array:
    velocity = sim.rov.velocity
    return np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s])
