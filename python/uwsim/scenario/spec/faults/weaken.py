"""Weaker propulsion: less thrust of a thruster, or less force or torque on an axis."""

from __future__ import annotations

from uwsim.scenario.spec.fault import FaultyVehicle, Overlay


def weaken_thruster(over: Overlay, vehicle: FaultyVehicle, thruster: str, share: float) -> None:
    """Reduce a thruster's thrust to a share of it."""
    over[f"{vehicle.name}.thrusters.{thruster}.health"] *= share


def weaken_axis(over: Overlay, vehicle: FaultyVehicle, axis: int, share: float) -> None:
    """Reduce the maximum force or torque on one axis of a vehicle without thrusters."""
    key = "max_force_n" if axis < 3 else "max_torque_nm"
    over[f"{vehicle.name}.{key}.{'xyz'[axis % 3]}"] *= share
