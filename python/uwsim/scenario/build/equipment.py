"""The equipment of a vehicle as core objects: thrusters and fins, battery, sensors, and pushes by schedule."""

from __future__ import annotations

import math

import numpy as np

from uwsim import _core
from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.scenario.build.earth import compass_field
from uwsim.scenario.spec.actuator import FinMount, ThrusterMount, ThrusterType
from uwsim.scenario.spec.battery import BatterySetup
from uwsim.scenario.spec.loose_body import AppliedWrench
from uwsim.scenario.spec.sensor import OWN_NOISE, Noise, SensorMount
from uwsim.scenario.spec.sensor_kind import DerivedKind, sensor_kind
from uwsim.scenario.spec.settings import Earth
from uwsim.scenario.spec.vehicle import VehicleModel


def actuators_spec(model: VehicleModel, *, by_voltage: bool = False) -> _core.ActuatorsSpec:
    """Return a vehicle's actuators: thrusters, fins and, for a vehicle without thrusters, its maximum wrench.

    by_voltage: whether performance sheets are required. Raises ScenarioError if a thruster has none.
    """
    spec = _core.ActuatorsSpec()
    if model.max_force_n is not None and model.max_torque_nm is not None:
        spec.full_wrench_body = np.array([*model.max_force_n, *model.max_torque_nm])
    spec.thrusters = [_thruster_parameters(name, mount, by_voltage) for name, mount in model.thrusters.items()]
    spec.fins = [_fin_parameters(name, mount) for name, mount in model.fins.items()]
    return spec


def thrust_curve(thruster: ThrusterType, gain: float = 1.0) -> _core.ThrustCurve:
    """Return thrust, multiplied by a gain, as a function of the command in [-1, 1]."""
    commands, thrusts_n = thruster.curve_points
    return _core.ThrustCurve(commands, [gain * thrust_n for thrust_n in thrusts_n])


def _thruster_parameters(name: str, mount: ThrusterMount, by_voltage: bool) -> _core.ThrusterParameters:
    thruster = mount.model
    parameters = _core.ThrusterParameters(name, mount.position_m, mount.axis, thrust_curve(thruster, mount.gain))
    if by_voltage:
        parameters.sheets = thruster.performance(mount.gain)
    parameters.health = mount.health
    parameters.ventilates = mount.ventilates
    parameters.is_vertical = mount.force is not None
    if mount.moved_from_m is not None:
        parameters.counter_body_m = mount.moved_from_m
    parameters.time_constant_s = mount.lag_s
    parameters.diameter_m = thruster.diameter_m
    parameters.bollard_coefficient = thruster.bollard_coefficient
    parameters.zero_thrust_advance_ratio = thruster.zero_thrust_advance_ratio or math.inf
    parameters.torque_per_thrust_m = thruster.torque_per_thrust_m
    parameters.spin = 1 if mount.spin == "clockwise" else -1
    return parameters


def _fin_parameters(name: str, mount: FinMount) -> _core.FinParameters:
    parameters = _core.FinParameters(name, mount.position_m, mount.span, mount.area_m2, mount.aspect_ratio)
    parameters.parasitic_drag = mount.parasitic_drag
    parameters.efficiency = mount.efficiency
    parameters.stalls = mount.stall_angle_deg is not None
    if mount.stall_angle_deg is not None:
        parameters.stall_angle_rad = math.radians(mount.stall_angle_deg)
        parameters.stall_sharpness_rad = math.radians(mount.stall_sharpness_deg)
    parameters.deflection_max_rad = math.radians(mount.deflection_max_deg)
    parameters.rate_max_rad_s = math.radians(mount.rate_max_deg_s)
    parameters.slipstream_of = mount.slipstream_of or ""
    return parameters


def battery_spec(setup: BatterySetup) -> _core.BatterySpec:
    """Return the spec of a battery's cells and its constant load."""
    spec, cells = _core.BatterySpec(), setup.model
    spec.capacity_ah = cells.capacity_ah
    spec.charges, spec.open_circuit_v = map(list, zip(*cells.open_circuit_v, strict=True))
    spec.resistance_ohm = cells.resistance_ohm
    spec.cutoff_v = cells.cutoff_v
    spec.hotel_w = setup.hotel_w
    spec.initial_charge = setup.initial_charge
    return spec


def sensor_spec(name: str, sensor: SensorMount, earth: Earth | None = None) -> _core.SensorSpec:
    """Return the sensor's spec, including the errors of each channel. Raises ScenarioError or ValueError.

    For a kind in Python, this is an exact sensor of its source. earth: place of the world, whose field compasses have.
    """
    overall = sensor.noise or Noise(std=sensor.noise_std or 0.0)
    kind = sensor_kind(sensor.kind)
    is_derived = isinstance(kind, DerivedKind)
    source = kind.source if isinstance(kind, DerivedKind) else sensor.kind
    given = {} if is_derived else {key: list(values) for key, values in sensor.parameters.items()}
    return _core.SensorSpec(
        name,
        source,
        sensor.position_m,
        of_yaw_pitch_roll_deg(sensor.yaw_pitch_roll_deg),
        parameters=_of_place(source, earth) | given,
        noise={
            channel: _noise_spec(sensor.channels.get(channel, Noise() if channel in OWN_NOISE else overall))
            for channel in (() if is_derived else kind.channels)
        },
        rate_hz=sensor.rate_hz or 0.0,
        latency_s=sensor.latency_s,
        drop_out=sensor.drop_out,
    )


def _of_place(source: str, earth: Earth | None) -> dict[str, list[float]]:
    """Return the parameters of a kind of sensor that the world's place implies. Raises ScenarioError."""
    if source == "compass":
        return compass_field(earth)
    return {"latitude_deg": [earth.latitude_deg]} if source == "gyrocompass" and earth is not None else {}


def measures_temperature(sensor: SensorMount) -> bool:
    """Return whether a sensor, or the source of one in Python, measures the water's temperature."""
    kind = sensor_kind(sensor.kind)
    return (kind.source if isinstance(kind, DerivedKind) else sensor.kind) in ("temperature", "ctd")


def _noise_spec(noise: Noise) -> _core.NoiseSpec:
    low, high = noise.limits or (-math.inf, math.inf)
    return _core.NoiseSpec(
        std=noise.std,
        density=noise.density,
        turn_on_std=noise.turn_on_std,
        bias_std=noise.bias_std,
        bias_time_s=noise.bias_time_s or 0.0,
        walk=noise.walk,
        instability=noise.instability,
        quantum=noise.quantum,
        limit_low=low,
        limit_high=high,
    )


FOREVER_S = 1e12


def applied_wrench(wrench: AppliedWrench, step_s: float) -> _core.AppliedWrench:
    """Return a scheduled wrench, with its times rounded to steps, of which it lasts at least one."""
    until_s = FOREVER_S if wrench.until_s is None else wrench.until_s
    parts = np.array([*wrench.force_n, *wrench.torque_nm])
    first = round(wrench.from_s / step_s)
    return _core.AppliedWrench(parts, wrench.axes == "world", first, max(first + 1, round(until_s / step_s)))
