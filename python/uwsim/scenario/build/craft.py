"""A vehicle's body in the water as a core object."""

from __future__ import annotations

from uwsim import _core
from uwsim.scenario.build.ballast import mass_with_ballast, trim_weights
from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.spec.vehicle import Trim, VehicleModel


def craft(model: VehicleModel, water_density_kg_m3: float, trim: Trim | None = None) -> _core.Craft:
    """Return the vehicle's equations of motion in water of this surface density.

    trim: of the vehicle; the published figures are without. Raises ScenarioError.
    """
    body = rigid_body(model, water_density_kg_m3)
    weights = trim_weights(model, body, trim, water_density_kg_m3)
    parameters = _core.CraftParameters()
    mass = mass_with_ballast(model, body, weights)
    parameters.mass_kg, parameters.centre_of_mass_body_m, parameters.inertia_kg_m2 = mass
    parameters.added_mass = model.matrix("added_mass")
    parameters.linear_damping = model.matrix("linear_damping")
    parameters.quadratic_damping = model.matrix("quadratic_damping")
    return _core.Craft(parameters, *vehicle_hull(model))
