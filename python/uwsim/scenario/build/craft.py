"""A vehicle's hull in the water as a core object."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.ballast import mass_with_ballast, trim_weights
from uwsim.scenario.build.compressibility import STEP_M
from uwsim.scenario.build.gravity import STANDARD_M_S2
from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.build.scale import require_floats, require_plausible_density
from uwsim.scenario.spec.vehicle import Trim, VehicleModel


def craft(
    model: VehicleModel,
    water_density_kg_m3: float,
    trim: Trim | None = None,
    buoyancy_share: NDArray[np.float64] | None = None,
    gravity_m_s2: float = STANDARD_M_S2,
) -> _core.Craft:
    """Return the vehicle's equations of motion in water with this surface density.

    trim: the vehicle's trim; None keeps the published mass and balance. buoyancy_share: the result of
    compressibility.buoyancy_share; by default the hull is as compressible as the water around it. gravity_m_s2: with
    which the trim has its net buoyancy. Raises ScenarioError.
    """
    parameters = _core.CraftParameters()
    parameters.mass_kg, parameters.centre_of_mass_body_m, parameters.inertia_kg_m2 = mass_properties(
        model, water_density_kg_m3, trim, gravity_m_s2
    )
    parameters.added_mass = model.matrix("added_mass")
    parameters.linear_damping = model.matrix("linear_damping")
    parameters.quadratic_damping = model.matrix("quadratic_damping")
    parameters.munk_share, parameters.crossflow_length_m = model.munk_share, model.crossflow_length_m
    if model.coefficients == "afloat":
        afloat = rigid_body(model, water_density_kg_m3)
        require_floats("coefficients", afloat.mass_kg, afloat.volume_m3, water_density_kg_m3)
        parameters.coefficients_volume_m3 = afloat.mass_kg / water_density_kg_m3
    if buoyancy_share is not None:
        parameters.buoyancy_share, parameters.buoyancy_share_step_m = buoyancy_share.tolist(), STEP_M
    return _core.Craft(parameters, *vehicle_hull(model))


def mass_properties(
    model: VehicleModel, water_density_kg_m3: float, trim: Trim | None = None, gravity_m_s2: float = STANDARD_M_S2
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg m2] in body axes.

    Trim and ballast are included. Raises ScenarioError.
    """
    body = rigid_body(model, water_density_kg_m3)
    mass = mass_with_ballast(model, body, trim_weights(model, body, trim, water_density_kg_m3, gravity_m_s2))
    require_plausible_density(model.name, mass[0], body.volume_m3, model.mesh_scale, "mass, trim and ballast")
    return mass
