"""A vehicle's mass with its ballast: two rigid bodies as one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.hull import RigidBody
from uwsim.scenario.spec.vehicle import VehicleModel

Floats = NDArray[np.float64]


def mass_with_ballast(model: VehicleModel, body: RigidBody) -> tuple[float, Floats, Floats]:
    """Return mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg m2], body axes.

    The ballast is a point mass; moments of inertia follow from the parallel axis theorem.
    """
    inertia = np.diag(body.inertia_kg_m2)
    if model.ballast_kg == 0:
        return body.mass_kg, body.centre_of_mass_m, inertia
    mass = body.mass_kg + model.ballast_kg
    at = np.asarray(model.ballast_position_m)
    centre = (body.mass_kg * body.centre_of_mass_m + model.ballast_kg * at) / mass
    for part_kg, part_m in ((body.mass_kg, body.centre_of_mass_m), (model.ballast_kg, at)):
        arm = part_m - centre
        inertia = inertia + part_kg * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, centre, inertia
