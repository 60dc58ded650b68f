"""Fields that a scenario omits, with the values that apply instead, and fields that have no effect in it."""

from __future__ import annotations

import math
from typing import Any

from uwsim.scenario import rigid_body
from uwsim.scenario.build.camera import core_optics
from uwsim.scenario.build.water import surface_density_kg_m3
from uwsim.scenario.spec.actuator import ThrusterMount
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.imaging_sonar import DEGREES, RADIANS, STRENGTHS, ImagingMount, imaging_kind
from uwsim.scenario.spec.json_schema import SensorFigure
from uwsim.scenario.spec.optics import Optics, visibility_m
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.sensor import OWN_NOISE, Noise, SensorMount
from uwsim.scenario.spec.sensor_kind import sensor_kind
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import SonarSetup
from uwsim.scenario.spec.water import ONE_WATER, LinearEnd, TableProfile, Water, WaterLevel
from uwsim.simulator.parameters.parameter import FieldType

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


OF_PHYSICS_MODE = ("bending", "rays_per_beam", "noise")


def idle(model: Model, field: str) -> str:
    """Return the reason why a field has no effect, or an empty string if it has one."""
    if isinstance(model, Water):
        return _idle_of_water(model, field)
    if isinstance(model, TableProfile) and any(getattr(level, field, None) is not None for level in model.levels or ()):
        return "the levels have it"
    if isinstance(model, Optics) and field == "jerlov" and model.coefficients is not None:
        return "optics.coefficients are given"
    if isinstance(model, VehicleModel) and field == "ballast_position_m" and model.ballast_kg == 0:
        return "ballast_kg is 0"
    if isinstance(model, SonarSetup) and field in OF_PHYSICS_MODE and model.mode != "physics":
        return "it is for `mode: physics` only"
    if isinstance(model, SensorMount):
        return _of_sensor(model, field)
    if isinstance(model, Noise) and field == "bias_time_s" and model.bias_std == 0:
        return "bias_std is 0"
    return ""


def _idle_of_water(water: Water, field: str) -> str:
    profile = water.profile
    if field in ONE_WATER and profile is not None:
        return "water.profile gives it"
    if field == "sound_speed_equation" and isinstance(profile, TableProfile):
        levels = profile.levels or ()
        return "water.profile gives the speed of sound" if levels and levels[0].sound_speed_m_s is not None else ""
    return ""


def _of_sensor(sensor: SensorMount, field: str) -> str:
    kind = sensor_kind(sensor.kind)
    channels = set(kind.channels) - set(OWN_NOISE)
    if field == "noise" and channels <= set(sensor.channels):
        return "each channel has its own" if channels else "this kind has no noise"
    units = {unit for name, (_, unit) in kind.channels.items() if name in channels - set(sensor.channels)}
    if field == "noise" and len(units) > 1 and sensor.noise is None and sensor.noise_std is None:
        return "its channels have different units: set channels"
    return ""


NOISE_UNITS = {"density": "{}/sqrt(Hz)", "walk": "{}/sqrt(s)", "bias_time_s": "s"}
STRENGTHS_TYPE = FieldType("structure", meaning="Lambert's strength of single surfaces, by name [dB]")


def sensor_figures(mount: SensorMount) -> dict[str, tuple[FieldType, tuple[float, ...]]]:
    """Return the type and values of each parameter specific to a sensor's kind, by name."""
    return {
        name: (_type(figure), tuple(mount.parameters.get(name) or (figure.by_default,) * figure.width))
        for name, figure in sensor_kind(mount.kind).parameters.items()
    }


def imaging_figures(mount: ImagingMount) -> dict[str, tuple[FieldType, Any]]:
    """Return the type and value of each imaging sonar parameter, by YAML key; angles are in degrees."""
    kind = imaging_kind(mount.kind)
    model = kind.model(**mount.figures)
    figures: dict[str, tuple[FieldType, Any]] = {}
    for name, figure in kind.parameters.items():
        value, optional = getattr(model, name), not math.isnan(figure.by_default)
        if name.endswith(RADIANS):
            degrees = float(f"{math.degrees(value):.12g}")  # the value as written in the file, without rounding errors
            figures[name.removesuffix(RADIANS) + DEGREES] = _type(figure, in_degrees=True), degrees
        else:
            figures[name] = _type(figure, optional=optional), value
    figures[STRENGTHS] = STRENGTHS_TYPE, dict(getattr(model, STRENGTHS)) or None
    return figures


def _type(figure: SensorFigure, *, optional: bool = False, in_degrees: bool = False) -> FieldType:
    low, high, unit = figure.low, figure.high, figure.unit
    if in_degrees:
        low, high, unit = math.degrees(low), math.degrees(high), "deg"
    return FieldType(figure.type, unit, low, high, optional=optional, meaning=figure.meaning)  # type: ignore[arg-type]


def noise_unit(scenario: Scenario, place: tuple[str | int, ...]) -> str:
    """Return the unit of a noise value at a key path, or "" if the sensor's channels have different units."""
    at: Any = scenario
    below = list(place)
    while not isinstance(at, SensorMount):
        part = below.pop(0)
        at = at[part] if isinstance(part, int) or isinstance(at, dict) else getattr(at, str(part))
    channels = {name: unit for name, (_, unit) in sensor_kind(at.kind).channels.items()}
    shared = {unit for name, unit in channels.items() if name not in OWN_NOISE}
    units = {channels[str(below[1])]} if below[0] == "channels" else shared
    figure = next(part for part in reversed(below) if isinstance(part, str))
    if figure == "bias_time_s":
        return "s"
    return NOISE_UNITS.get(figure, "{}").format(units.pop()) if len(units) == 1 else ""
