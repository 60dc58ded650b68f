"""Effective values of fields that a scenario omits because a model or a mesh provides them."""

from __future__ import annotations

from typing import Any

from uwsim.scenario import rigid_body
from uwsim.scenario.build.camera import core_optics
from uwsim.scenario.build.water import surface_density_kg_m3
from uwsim.scenario.spec.actuator import ThrusterMount
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.optics import Optics, visibility_m
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.sensor import Noise, SensorMount
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import SonarSetup
from uwsim.scenario.spec.water import LinearEnd, Water, WaterLevel

NO_FORCES = (0.0,) * 6


def effective(owner: Model, field: str, scenario: Scenario) -> Any:
    """Return a field's effective value: the value set or, if omitted, the value that applies instead."""
    own = getattr(owner, field)
    if isinstance(owner, SonarSetup):
        return _of_sonar(owner, field, own)
    if isinstance(owner, SensorMount) and field == "noise":
        return own or Noise(std=owner.noise_std or 0.0)
    if own is None and isinstance(owner, VehicleModel):
        return _of_vehicle(owner, field, scenario)
    if own is None and isinstance(owner, ThrusterMount):
        return owner.lag_s
    if own is None and isinstance(owner, Optics) and field == "visibility_m":
        return visibility_m(core_optics(owner).water)
    if own is None and isinstance(owner, Water | WaterLevel | LinearEnd):
        return _of_water(owner, field)
    return own


def _of_water(water: Water | WaterLevel | LinearEnd, field: str) -> float | None:
    if isinstance(water, Water) and water.profile is not None:
        return None
    following = {"density_kg_m3": water.state().density, "salinity_psu": water.state().salinity}
    return following.get(field)


def _of_sonar(setup: SonarSetup, field: str, own: Any) -> Any:
    model = setup.loaded
    if field == "model":
        return own if isinstance(own, int) else own.name
    if field in ("noise", "tilt_rate_deg_s"):
        return getattr(model, field)
    if own is None and field == "receivers":
        return model.receivers
    if own is None and field in ("frequency_hz", "range_max_m"):
        return getattr(model.band(setup.frequency_hz), field)
    return own


def _of_vehicle(model: VehicleModel, field: str, scenario: Scenario) -> Any:
    if field == "added_mass" and model.added_mass_matrix is None:
        return NO_FORCES
    if field not in ("mass_kg", "centre_of_buoyancy_m", "inertia_kg_m2"):
        return None
    value = getattr(rigid_body(model, surface_density_kg_m3(scenario.water)), field)
    return float(value) if field == "mass_kg" else tuple(value.tolist())
