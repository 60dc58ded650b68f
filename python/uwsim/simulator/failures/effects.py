"""The effect of each kind of fault: which parameters it changes, and by how much."""

from __future__ import annotations

from typing import Any

from uwsim.base.axes import AXES
from uwsim.base.did_you_mean import did_you_mean
from uwsim.instruments.distortion import Distortion
from uwsim.scenario.spec.fault import (
    BatteryFault,
    CameraFault,
    CurrentFault,
    FaultModel,
    LeakFault,
    SensorFault,
    SonarFault,
    ThrusterFault,
)
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.simulator.vehicle import Vehicle

CURRENT = "water.current_world_m_s"
COORDINATES = ("x", "y", "z")
FASTEST_M_S = 5.0  # limit on a current's velocity components, as in scenarios


def check(spec: FaultModel, vehicle: Vehicle, scenario: Scenario) -> None:
    """Raise ValueError if a fault refers to parts that the vehicle lacks."""
    if isinstance(spec, ThrusterFault):
        _check_thruster(spec, _model(scenario, vehicle.name), vehicle)
    if isinstance(spec, SensorFault):
        _check_sensor(spec, vehicle)
    if isinstance(spec, SonarFault) and not vehicle.sonars:
        raise ValueError(f"kind = 'sonar': vehicle '{vehicle.name}' carries no multibeam")
    if isinstance(spec, CameraFault) and spec.camera not in (known := list(_model(scenario, vehicle.name).cameras)):
        rule = f"must be one of {', '.join(known) or 'none'}{did_you_mean(spec.camera, known)}"
        raise ValueError(f"camera = {spec.camera!r}: {rule}")


def _check_thruster(spec: ThrusterFault, model: VehicleModel, vehicle: Vehicle) -> None:
    if spec.axis is not None and model.thrusters:
        raise ValueError(
            f"axis: vehicle '{vehicle.name}' has thrusters: {', '.join(model.thrusters)}; name one of them"
        )
    if spec.thruster is not None and spec.thruster not in model.thrusters:
        rule = f"must be one of {', '.join(model.thrusters)}{did_you_mean(spec.thruster, model.thrusters)}"
        none = f"vehicle '{vehicle.name}' has no thrusters; give an axis: {', '.join(AXES)}"
        raise ValueError(f"thruster = {spec.thruster!r}: {rule if model.thrusters else none}")


def _check_sensor(spec: SensorFault, vehicle: Vehicle) -> None:
    if spec.sensor not in vehicle.sensors:
        known = list(vehicle.sensors)
        raise ValueError(
            f"sensor = {spec.sensor!r}: must be one of {', '.join(known)}{did_you_mean(spec.sensor, known)}"
        )
    fields = vehicle.sensors[spec.sensor].unit
    if spec.mode != "bias":
        return
    if isinstance(fields, dict):
        biasable = [name for name in fields if name != "orientation_xyzw"]
        if spec.field not in biasable:
            raise ValueError(f"field = {spec.field!r}: must be one of {', '.join(biasable)}")
    elif spec.field is not None:
        raise ValueError(f"field = {spec.field!r}: sensor '{spec.sensor}' has one quantity; leave it out")


def lay(spec: FaultModel, vehicle: str, water_kg: float, scenario: Scenario, over: dict[str, Any]) -> None:
    """Apply a fault's effect on top of a scenario's parameters. over: values by name, after earlier faults."""
    model = _model(scenario, vehicle)
    if isinstance(spec, ThrusterFault):
        if spec.thruster is not None:
            _weaken_thruster(vehicle, spec.thruster, spec.health, model, over)
        else:
            _weaken_axis(vehicle, AXES.index(str(spec.axis)), spec.health, model, over)
    elif isinstance(spec, BatteryFault):
        for name in model.thrusters:
            _weaken_thruster(vehicle, name, spec.thrust, model, over)
        for axis in range(6) if not model.thrusters else ():
            _weaken_axis(vehicle, axis, spec.thrust, model, over)
    elif isinstance(spec, SensorFault):
        if spec.mode == "off":
            over[f"{vehicle}.sensors.{spec.sensor}.on"] = False
    elif isinstance(spec, SonarFault):
        over[f"{vehicle}.sonar.on"] = False
    elif isinstance(spec, CameraFault):
        over[f"{vehicle}.cameras.{spec.camera}.on"] = False
    elif isinstance(spec, LeakFault):
        _add_water(vehicle, water_kg, spec.position_m or model.centre_of_mass_m, model, over)
    elif isinstance(spec, CurrentFault):
        for k, speed in enumerate(spec.velocity_world_m_s):
            name = f"{CURRENT}.{COORDINATES[k]}"
            total = over.get(name, scenario.water.current_world_m_s[k]) + speed
            over[name] = min(max(total, -FASTEST_M_S), FASTEST_M_S)


def distort(spec: SensorFault, vehicle: Vehicle) -> None:
    """Start falsifying a sensor's readings."""
    sensor = vehicle.sensors[spec.sensor]
    if spec.mode == "stuck":
        sensor.stick()
    elif spec.mode == "bias":
        sensor.distort(Distortion(field=spec.field, bias=float(spec.bias or 0.0)))


def _weaken_thruster(vehicle: str, thruster: str, share: float, model: VehicleModel, over: dict[str, Any]) -> None:
    name = f"{vehicle}.thrusters.{thruster}.health"
    over[name] = over.get(name, model.thrusters[thruster].health) * share


def _weaken_axis(vehicle: str, axis: int, share: float, model: VehicleModel, over: dict[str, Any]) -> None:
    """Reduce the maximum force or torque on one axis of a vehicle without thrusters."""
    figures, key = (model.max_force_n, "max_force_n") if axis < 3 else (model.max_torque_nm, "max_torque_nm")
    assert figures is not None
    name = f"{vehicle}.{key}.{COORDINATES[axis % 3]}"
    over[name] = over.get(name, figures[axis % 3]) * share


def _add_water(
    vehicle: str, water_kg: float, at_m: tuple[float, float, float], model: VehicleModel, over: dict[str, Any]
) -> None:
    """Add water as ballast (weight and inertia, no buoyancy), merged with other ballast at the common centre."""
    if water_kg <= 0.0:
        return
    mass, place = f"{vehicle}.ballast_kg", f"{vehicle}.ballast_position_m"
    before_kg = over.get(mass, model.ballast_kg)
    total_kg = before_kg + water_kg
    over[mass] = total_kg
    for k, key in enumerate(COORDINATES):
        before_m = over.get(f"{place}.{key}", model.ballast_position_m[k])
        over[f"{place}.{key}"] = (before_kg * before_m + water_kg * at_m[k]) / total_kg


def _model(scenario: Scenario, vehicle: str) -> VehicleModel:
    return next(entry.model for entry in scenario.vehicles if entry.name == vehicle)
