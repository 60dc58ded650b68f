"""Fields that have no effect in the current scenario; setting one raises an error that states why."""

from __future__ import annotations

from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.optics import Optics
from uwsim.scenario.spec.sensor import OWN_NOISE, Noise, SensorMount
from uwsim.scenario.spec.sensor_kind import sensor_kind
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import SonarSetup
from uwsim.scenario.spec.water import ONE_WATER, TableProfile, Water

OF_PHYSICS_MODE = ("bending", "rays_per_beam", "noise")


def idle(model: Model, field: str) -> str:
    """Return the reason why a field has no effect, or an empty string if it has one."""
    if isinstance(model, Water):
        return _of_water(model, field)
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


def _of_water(water: Water, field: str) -> str:
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
