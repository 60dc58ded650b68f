"""A vehicle's body in the water as a core object."""

from __future__ import annotations

from uwsim import _core
from uwsim.scenario.build.ballast import mass_with_ballast
from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.spec.vehicle import VehicleModel


def craft(model: VehicleModel, water_density_kg_m3: float) -> _core.Craft:
    """Return the vehicle's equations of motion; the density makes a neutral one's mass. Raises ScenarioError."""
    body = rigid_body(model, water_density_kg_m3)
    parameters = _core.CraftParameters()
    parameters.mass_kg, parameters.centre_of_mass_body_m, parameters.inertia_kg_m2 = mass_with_ballast(model, body)
    parameters.added_mass = model.matrix("added_mass")
    parameters.linear_damping = model.matrix("linear_damping")
    parameters.quadratic_damping = model.matrix("quadratic_damping")
    return _core.Craft(parameters, *vehicle_hull(model))
