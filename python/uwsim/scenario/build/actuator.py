"""A vehicle's thrusters and fins as core objects."""

from __future__ import annotations

import math

import numpy as np

from uwsim import _core
from uwsim.scenario.spec.actuator import FinMount, ThrusterMount, ThrusterType
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
