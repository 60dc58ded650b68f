"""A vehicle with what its file does not state, and the simplest model of one."""

from __future__ import annotations

from typing import Any

from uwsim.scenario.build.afloat import is_boat
from uwsim.scenario.build.hull import rigid_body
from uwsim.scenario.spec.vehicle import VehicleModel


def completed(model: VehicleModel, density_kg_m3: float) -> tuple[VehicleModel, tuple[str, ...]]:
    """Return a vehicle that states its volume, centre of buoyancy and inertia, and the keys that were added.

    What its file does not state is that of its hull, in water of this density.
    """
    body = rigid_body(model, density_kg_m3)
    own = {
        "volume_m3": body.volume_m3,
        "centre_of_buoyancy_m": tuple(map(float, body.centre_of_buoyancy_m)),
        "inertia_kg_m2": tuple(map(float, body.inertia_kg_m2)),
    }
    added = {key: value for key, value in own.items() if getattr(model, key) is None}
    return model.model_copy(update=added), tuple(added)


def double_integrator(model: VehicleModel, density_kg_m3: float) -> VehicleModel:
    """Return the simplest model of a vehicle: its masses and thrusters, without drag and lift; neutral, but for a boat.

    A boat still floats upright.
    """
    whole, _ = completed(model, density_kg_m3)
    still = dict.fromkeys(("linear_damping", "quadratic_damping"), (0.0,) * 6)
    update: dict[str, Any] = {
        **still,
        "linear_damping_matrix": None,
        "quadratic_damping_matrix": None,
        "munk_share": 0.0,
        "fins": {},
    }
    if not is_boat(model, density_kg_m3):
        update |= {"buoyancy": "neutral", "mass_kg": None, "centre_of_buoyancy_m": whole.centre_of_mass_m}
    return whole.model_copy(update={**update, "crossflow_length_m": 0.0, "windage": None})
