"""The unknowns of an identification, and their prior distributions.

An unknown is a parameter of the vehicle file, the current, or the delay of the commands. Its prior is normal around the
file's value, in the logarithm for positive quantities (mass, added mass, drag, thrust, lag) and directly for positions,
the current and the delay. The
spreads are broad on purpose: published sets for the same vehicle differ by this much (compare bluerov2_wu with
bluerov2_tank).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.base.axes import AXES
from uwsim.scenario.spec.vehicle import VehicleModel

Array = NDArray[np.float64]

SPREADS = {  # prior standard deviations; of the logarithm for positive quantities
    "mass_kg": 0.1,
    "centre_of_mass_m": 0.3,
    "centre_of_buoyancy_m": 0.3,
    "added_mass": 0.4,
    "linear_damping": 0.5,
    "quadratic_damping": 0.5,
    "thrust_gain": 0.15,
    "thrust_lag": 0.3,
    "current_m_s": 0.15,
    "command_delay": 0.1,
}
"""For positions: a share of the distance between the two centres, but at least LEAST_M."""
LEAST_M = 0.002
DELAY = "command_delay"
"""The unknown by which all commands take effect later than logged; it is no parameter of the vehicle."""
UNITS = {
    "mass_kg": "kg", "centre_of_mass_m": "m", "centre_of_buoyancy_m": "m", "thrust_gain": "", "thrust_lag": "s",
    "current_m_s": "m/s", "command_delay": "s",
}  # fmt: skip
AXIS_UNITS = {
    "added_mass": ("kg", "kg m2"),
    "linear_damping": ("N s/m", "N m s/rad"),
    "quadratic_damping": ("N s2/m2", "N m s2/rad2"),
}


@dataclass(frozen=True)
class Unknown:
    """A quantity to be identified.

    name: its name, such as added_mass.surge. names: the simulator's parameters that it sets. spread: standard deviation
    of the prior, of the logarithm if `positive`. scale: factor from the identified value to each parameter.
    """

    name: str
    unit: str
    value: float
    spread: float
    positive: bool
    names: tuple[str, ...]

    def at(self, z: float) -> float:
        """Return the value that lies z prior standard deviations from the file's value."""
        return self.value * float(np.exp(self.spread * z)) if self.positive else self.value + self.spread * z

    def slope(self, z: float) -> float:
        """Return the derivative of the value with respect to z."""
        return self.spread * self.at(z) if self.positive else self.spread


def unknowns(
    model: VehicleModel, vehicle: str, spreads: Mapping[str, float] | None = None, known: tuple[str, ...] = ()
) -> list[Unknown]:
    """Return the unknowns of a vehicle. Coefficients that are zero in its file stay zero.

    vehicle: its name in the scenario. spreads: replacements for some of SPREADS; in metres for positions, in metres per
    second for the current. known: names of groups or unknowns that keep the file's value. Raises ValueError for an
    unknown name or a spread that is not positive.
    """
    given = dict(spreads or {})
    found: list[Unknown] = []
    gap_m = float(np.linalg.norm(np.subtract(_centre_of_buoyancy(model), model.centre_of_mass_m)))
    for key, spread in given.items():
        _require_group(key, "spread")
        if not (np.isfinite(spread) and 0 < spread <= 10):
            raise ValueError(f"spread.{key} = {spread}: must be in (0, 10]")

    def add(name: str, value: float, positive: bool, *names: str) -> None:
        group = name.split(".")[0]
        spread = given.get(group, SPREADS[group])
        if group.startswith("centre_of") and group not in given:
            spread = max(spread * gap_m, LEAST_M)
        if positive and value == 0.0:
            return
        index = AXES.index(name.split(".")[1]) if group in AXIS_UNITS else 0
        unit = AXIS_UNITS[group][index // 3] if group in AXIS_UNITS else UNITS[group]
        found.append(Unknown(name, unit, value, spread, positive, names))

    if model.mass_kg is not None:
        add("mass_kg", model.mass_kg, True, f"{vehicle}.mass_kg")
    for key, values in (
        ("centre_of_mass_m", model.centre_of_mass_m),
        ("centre_of_buoyancy_m", model.centre_of_buoyancy_m),
    ):
        for axis, value in zip("xyz", values or (), strict=False):
            add(f"{key}.{axis}", value, False, f"{vehicle}.{key}.{axis}")
    for key, place in (
        ("added_mass", "added_mass"), ("linear_damping", "drag.linear"), ("quadratic_damping", "drag.quadratic"),
    ):  # fmt: skip
        for axis, value in zip(AXES, getattr(model, key) or (), strict=False):
            add(f"{key}.{axis}", value, True, f"{vehicle}.{place}.{axis}")
    for key, place, of_each in (
        ("thrust_gain", "gain", {mount.gain for mount in model.thrusters.values()}),
        ("thrust_lag", "time_constant_s", {mount.model.time_constant_s for mount in model.thrusters.values()}),
    ):
        if len(of_each) == 1:  # one for all thrusters
            add(key, of_each.pop(), True, *(f"{vehicle}.thrusters.{name}.{place}" for name in model.thrusters))
    for axis in "xy":
        add(f"current_m_s.{axis}", 0.0, False, f"water.current_world_m_s.{axis}")
    add(DELAY, 0.0, False)
    names = {u.name for u in found}
    for name in known:
        if name not in names:
            _require_group(name, "known")
    return [u for u in found if u.name not in known and u.name.split(".")[0] not in known]


def parameters_at(found: list[Unknown], z: Array) -> dict[str, float]:
    """Return the simulator's parameters at z (n,)."""
    return {name: u.at(float(value)) for u, value in zip(found, z, strict=True) for name in u.names}


def _centre_of_buoyancy(model: VehicleModel) -> tuple[float, ...]:
    return model.centre_of_buoyancy_m or model.centre_of_mass_m


def _require_group(key: str, where: str) -> None:
    if key not in SPREADS:
        raise ValueError(f"{where}: '{key}': must be one of {', '.join(SPREADS)}")
