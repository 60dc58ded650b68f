"""The unknowns of an identification, and their prior distributions.

An unknown is a parameter of the vehicle file, the current, or the delay of the commands. Its prior is normal around the
file's value, in the logarithm for positive quantities (mass, added mass, drag, thrust, lag) and directly for positions,
the current and the delay. The spreads are broad on purpose: published sets for the same vehicle differ by this much
(compare bluerov2_wu with bluerov2_tank).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.scenario.spec.vehicle import VehicleModel

MatrixKey = Literal["added_mass", "linear_damping", "quadratic_damping"]

SPREADS = {  # prior standard deviations; of the logarithm for positive quantities
    "mass_kg": 0.1,
    "volume_m3": 0.1,
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
SIGNED = ("centre_of_mass_m", "centre_of_buoyancy_m", "current_m_s", "command_delay")
"""Groups of quantities that may be negative, so that their priors are normal in the value itself."""
DELAY = "command_delay"
"""The unknown by which all commands take effect later than logged; it is no parameter of the vehicle."""
UNITS = {
    "mass_kg": "kg", "volume_m3": "m3", "centre_of_mass_m": "m", "centre_of_buoyancy_m": "m", "thrust_gain": "",
    "thrust_lag": "s", "current_m_s": "m/s", "command_delay": "s",
}  # fmt: skip
AXIS_UNITS = {
    "added_mass": ("kg", "kg m2"),
    "linear_damping": ("N s/m", "N m s/rad"),
    "quadratic_damping": ("N s2/m2", "N m s2/rad2"),
}


Place = tuple[str | int, ...]
"""The keys and indices that lead to a number in a vehicle's file."""


@dataclass(frozen=True)
class Unknown:
    """A quantity to be identified.

    name: its name, such as added_mass.surge. spread: standard deviation of the prior, of the logarithm if `positive`.
    names: the simulator's parameters that it sets. places: the numbers in the vehicle's file that it replaces. coupled:
    off-diagonal numbers of a matrix, by parameter and place; each is multiplied by the root of the change of this
    diagonal one, so that the matrix stays symmetric and definite.
    """

    name: str
    unit: str
    value: float
    spread: float
    positive: bool
    names: tuple[str, ...] = ()
    places: tuple[Place, ...] = ()
    coupled: tuple[tuple[str, Place, float], ...] = ()

    @property
    def group(self) -> str:
        """The first part of its name, such as added_mass."""
        return self.name.partition(".")[0]

    def at(self, z: float) -> float:
        """Return the value that lies z prior standard deviations from the file's value."""
        return self.value * float(np.exp(self.spread * z)) if self.positive else self.value + self.spread * z


def unknowns(
    model: VehicleModel,
    vehicle: str,
    spreads: Mapping[str, float] | None = None,
    known: tuple[str, ...] = (),
    *,
    added: tuple[str, ...] = (),
) -> list[Unknown]:
    """Return the unknowns of a vehicle. Coefficients that are zero in its file stay zero.

    vehicle: its name in the scenario. added: the keys that its file does not state, see `completed`: the volume is
    unknown only if it is one of them. spreads: replacements for some of SPREADS; in metres for positions, in metres per
    second for the current. known: names of groups or unknowns that keep the file's value. Raises ValueError for an
    unknown name or a spread that is not positive.
    """
    given = dict(spreads or {})
    for key, spread in given.items():
        _require_group(key, "spread")
        if not (np.isfinite(spread) and 0 < spread <= 10):
            raise ValueError(f"spread.{key} = {spread}: must be in (0, 10]")
    own = SPREADS | _spreads_of_centres(model, added) | given
    own_values = [*_of_vehicle(model, vehicle, is_volume_known="volume_m3" not in added)]
    found = [each for each in own_values if each.value or not each.positive]
    found += [_unknown(f"current_m_s.{axis}", 0.0, (f"water.current_world_m_s.{axis}",)) for axis in "xy"]
    found.append(_unknown(DELAY, 0.0))
    names = {each.name for each in found}
    for name in known:
        if name not in names:
            _require_group(name, "known")
    left = [each for each in found if each.name not in known and each.group not in known]
    return [replace(each, spread=own[each.group]) for each in left]


def _spreads_of_centres(model: VehicleModel, added: tuple[str, ...]) -> dict[str, float]:
    """Return the spreads of both centres [m].

    A hull's mesh has its volume within that volume's spread. What is too much of it, or missing, may be anywhere in it:
    in a cube of this volume, it moves the centre of buoyancy by the same share of side / sqrt(12), and the distance of
    the centres may be larger by as much. Narrower, both would draw the centres together, and mass and volume up.
    """
    buoyancy_m, volume_m3 = model.centre_of_buoyancy_m or model.centre_of_mass_m, model.volume_m3 or 0.0
    is_of_mesh = "centre_of_buoyancy_m" in added
    mesh_m = SPREADS["volume_m3"] * float(np.cbrt(volume_m3)) / math.sqrt(12.0) if is_of_mesh else 0.0
    gap_m = float(np.linalg.norm(np.subtract(buoyancy_m, model.centre_of_mass_m))) + mesh_m
    own = {key: max(SPREADS[key] * gap_m, LEAST_M) for key in SPREADS if key.startswith("centre_of")}
    return own | {"centre_of_buoyancy_m": math.hypot(own["centre_of_buoyancy_m"], mesh_m)}


def _of_vehicle(model: VehicleModel, vehicle: str, *, is_volume_known: bool) -> Iterator[Unknown]:
    if model.mass_kg is not None:
        yield _unknown("mass_kg", model.mass_kg, (f"{vehicle}.mass_kg",), (("mass_kg",),))
    if model.volume_m3 is not None and not is_volume_known:
        yield _unknown("volume_m3", model.volume_m3, (f"{vehicle}.volume_m3",), (("volume_m3",),))
    for key in ("centre_of_mass_m", "centre_of_buoyancy_m"):
        for k, value in enumerate(getattr(model, key) or ()):
            yield _unknown(f"{key}.{'xyz'[k]}", value, (f"{vehicle}.{key}.{'xyz'[k]}",), ((key, k),))
    yield from _matrix(model, "added_mass", f"{vehicle}.added_mass")
    yield from _matrix(model, "linear_damping", f"{vehicle}.drag.linear")
    yield from _matrix(model, "quadratic_damping", f"{vehicle}.drag.quadratic")
    for name, key in (("thrust_gain", "gain"), ("thrust_lag", "time_constant_s")):
        values = {mount: each.gain if key == "gain" else each.lag_s for mount, each in model.thrusters.items()}
        for value in dict.fromkeys(values.values()):  # equal thrusters share an unknown
            alike = [mount for mount in values if values[mount] == value]
            yield _unknown(
                name if len(alike) == len(values) else f"{name}.{'+'.join(alike)}",
                value,
                tuple(f"{vehicle}.thrusters.{mount}.{key}" for mount in alike),
                tuple(("thrusters", mount, key) for mount in alike),
            )


def _matrix(model: VehicleModel, key: MatrixKey, parameter: str) -> Iterator[Unknown]:
    is_full = getattr(model, f"{key}_matrix") is not None
    matrix = model.matrix(key)
    for k, axis in enumerate(AXES):
        coupled = tuple(
            (f"{parameter}.{AXES[i]}_{AXES[j]}", (f"{key}_matrix", i, j), float(matrix[i, j]))
            for i in range(6)
            for j in range(6)
            if k in (i, j) and i != j and matrix[i, j] and is_full
        )
        place: Place = (f"{key}_matrix", k, k) if is_full else (key, k)
        yield _unknown(f"{key}.{axis}", float(matrix[k, k]), (f"{parameter}.{axis}",), (place,), coupled)


def _unknown(
    name: str,
    value: float,
    names: tuple[str, ...] = (),
    places: tuple[Place, ...] = (),
    coupled: tuple[tuple[str, Place, float], ...] = (),
) -> Unknown:
    group, _, axis = name.partition(".")
    unit = AXIS_UNITS[group][AXES.index(axis) // 3] if group in AXIS_UNITS else UNITS[group]
    return Unknown(name, unit, value, SPREADS[group], group not in SIGNED, names, places, coupled)


def parameters_at(found: list[Unknown], z: Floats) -> dict[str, float]:
    """Return the simulator's parameters at z (n,)."""
    return _numbers(found, z, lambda each: each.names, 0)


def numbers_at(found: list[Unknown], z: Floats) -> dict[Place, float]:
    """Return the numbers in the vehicle's file at z (n,), by place."""
    return _numbers(found, z, lambda each: each.places, 1)


def _numbers(found: list[Unknown], z: Floats, own: Callable[[Unknown], tuple[Any, ...]], kind: int) -> dict[Any, float]:
    values: dict[Any, float] = {}
    for each, at in zip(found, z, strict=True):
        value = each.at(float(at))
        values |= dict.fromkeys(own(each), value)
        for coupling in each.coupled:
            key = coupling[kind]
            values[key] = values.get(key, coupling[2]) * math.sqrt(value / each.value)
    return values


def _require_group(key: str, where: str) -> None:
    if key not in SPREADS:
        raise ValueError(f"{where}: '{key}': must be one of {', '.join(SPREADS)}")
