"""Combines a vehicle's mass with trim weights and ballast into one rigid body."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.gravity import STANDARD_M_S2
from uwsim.scenario.build.hull import RigidBody
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.vehicle import Trim, VehicleModel

Floats = NDArray[np.float64]
MAX_TAKEN_OFF = 0.5
"""The largest fraction of a vehicle's mass that trimming may remove."""


class PointMass(NamedTuple):
    """A point mass. mass_kg: negative for removed weight. position_m: (3,), body frame."""

    mass_kg: float
    position_m: Floats


def trim_weights(
    model: VehicleModel, body: RigidBody, trim: Trim | None, water_density_kg_m3: float,
    gravity_m_s2: float = STANDARD_M_S2,
) -> PointMass:  # fmt: skip
    """Return the weight that trims the body: rho V - B / g - m. Raises ScenarioError if it is unrealistic."""
    if trim is None:
        return PointMass(0.0, body.centre_of_mass_m)
    displaced_kg = water_density_kg_m3 * body.volume_m3
    added_kg = displaced_kg - trim.net_buoyancy_n / gravity_m_s2 - body.mass_kg
    if added_kg < -MAX_TAKEN_OFF * body.mass_kg:
        most_n = (displaced_kg - (1.0 - MAX_TAKEN_OFF) * body.mass_kg) * gravity_m_s2
        raise ScenarioError(
            f"vehicle '{model.name}': trim.net_buoyancy_n = {trim.net_buoyancy_n:g} N: must be at most {most_n:.4g} N "
            f"in this water: it would remove {-added_kg:.3g} kg of its {body.mass_kg:.4g} kg, more than half",
            at=("trim", "net_buoyancy_n"),
        )
    at = body.centre_of_mass_m if trim.position_m is None else np.asarray(trim.position_m)
    return PointMass(added_kg, at)


def mass_with_ballast(model: VehicleModel, body: RigidBody, trim: PointMass) -> tuple[float, Floats, Floats]:
    """Return the mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg m2], in body axes.

    Trim and ballast are point masses; moments of inertia follow from the parallel axis theorem. Raises ScenarioError.
    """
    ballast = PointMass(model.ballast_kg, np.asarray(model.ballast_position_m))
    masses = [each for each in (trim, ballast) if each.mass_kg != 0.0]
    inertia = np.diag(body.inertia_kg_m2)
    if not masses:
        return body.mass_kg, body.centre_of_mass_m, inertia
    parts = [PointMass(body.mass_kg, body.centre_of_mass_m), *masses]
    mass = sum(part.mass_kg for part in parts)
    centre = sum((part.mass_kg * part.position_m for part in parts), np.zeros(3)) / mass
    for part in parts:
        arm = part.position_m - centre
        inertia = inertia + part.mass_kg * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    smallest, middle, largest = np.linalg.eigvalsh(inertia)
    if smallest <= 0.0 or largest > (smallest + middle) * (1.0 + 1e-9):
        rule = f"{-trim.mass_kg:.3g} kg cannot be removed there: no physical body would remain; choose a nearer place"
        raise ScenarioError(f"vehicle '{model.name}': trim.position_m: {rule}", at=("trim", "position_m"))
    return mass, centre, inertia
