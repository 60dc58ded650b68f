"""The common part of all imaging sonars: acoustic parameters, their surroundings, and the native instrument."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.spec.imaging_sonar import core_kind, own_figures

Levels = NDArray[np.float32]
Labels = NDArray[np.uint16]

TERRAIN_LABEL = 1
ACCEPTED: dict[str, Any] = {
    "number": int | float | np.integer | np.floating,
    "whole number": int | np.integer,
    "flag": bool | np.bool_ | int | np.integer,
}
"""Python types of a parameter, by _core.Parameter.type."""


class Place(Protocol):
    """The part of a simulator that an imaging sonar needs."""

    @property
    def scene(self) -> _core.RayScene:
        """The surfaces that return echoes."""

    @property
    def world(self) -> _core.World:
        """The world, including the water in which the sound travels."""

    @property
    def strengths_db(self) -> Mapping[str, float]:
        """Lambert strength of each surface's material by name: World.label_names, then the vehicles in `scene`."""

    @property
    def seed(self) -> int:
        """The random seed of speckle and noise."""

    @property
    def threads(self) -> int:
        """Number of threads to use; results do not depend on it."""

    @property
    def time_ns(self) -> int:
        """Simulated time in nanoseconds."""


@dataclass(frozen=True, kw_only=True)
class Acoustics:
    """Acoustic parameters common to all imaging sonars. Levels are in dB re 1 uPa.

    source_level_db: level at 1 m. noise_level_db: noise in the receiver's band, after beam forming. Surfaces scatter
    like the scenario's materials unless overridden by one of these Lambert strengths (per square metre at normal
    incidence): bottom_strength_db for the terrain, solid_strength_db for all solids, strengths_db for single surfaces
    by Simulator.label_names. range_max_m is divided into range_bins, each of which is one resolution cell. The
    time-varied gain is gain_db_decade log10 R + 2 alpha R, where alpha is the absorption of the water at the head
    (Francois and Garrison); if time_varied_gain is False, levels remain as received. looks: number of independent looks
    averaged in a cell; 1 gives full speckle (Rayleigh amplitude), 0 gives none. multipath: whether echoes with more
    than one bounce are received: second echoes of the bed, and images in the water's surface.
    """

    kind: ClassVar[str] = ""
    """Name of the kind in YAML; see uwsim.scenario.spec.imaging_sonar."""

    frequency_hz: float
    source_level_db: float
    noise_level_db: float
    range_max_m: float
    range_bins: int
    bottom_strength_db: float | None = None
    solid_strength_db: float | None = None
    strengths_db: Mapping[str, float] = field(default_factory=dict)
    time_varied_gain: bool = True
    # 30 for spreading over a cell that grows with range, plus 20 for Lambert's law, under which the strength of a level
    # bottom decreases as (height / range)^2: together they make a flat bottom appear uniform.
    gain_db_decade: float = 50.0
    looks: int = 1
    multipath: bool = False

    @property
    def bin_m(self) -> float:
        """Width of a range bin."""
        return self.range_max_m / self.range_bins

    @property
    def bin_centres_m(self) -> NDArray[np.float64]:
        """Centres of the range bins, (bins,) float64."""
        return np.asarray((np.arange(self.range_bins) + 0.5) * self.bin_m, np.float64)


def check(model: Acoustics, sim: Place | None = None) -> None:
    """Raise ValueError, naming the parameter, if a model is invalid.

    strengths_db is checked only if a sim is given.
    """
    instrument(sim, model)


def instrument(sim: Place | None, model: Acoustics, expected: type[Acoustics] = Acoustics) -> _core.ImagingSonar:
    """Return the native instrument. Raises ValueError, naming the parameter, if the model is invalid."""
    if not isinstance(model, expected) or not model.kind:
        raise ValueError(
            f"model is a {type(model).__name__}: must be a {expected.__name__} of uwsim.instruments.sonars.imaging"
        )
    if not isinstance(model.strengths_db, Mapping):
        raise ValueError(f"sonar.strengths_db = {model.strengths_db!r}: must be dB by name")
    given = {entry.name: getattr(model, entry.name) for entry in fields(model) if entry.name != "strengths_db"}
    for name, figure in own_figures(type(model)).items():
        value = _number(name, given.pop(name), figure.type)
        if not figure.low <= value <= figure.high:
            rule = f"must be in [{figure.low:g}, {figure.high:g}] {figure.unit}".rstrip()
            raise ValueError(f"sonar.{name} = {value:g} {figure.unit}".rstrip() + f": {rule}")
    kind = core_kind(type(model))
    parameters = _core.imaging_kind(kind).parameters
    figures = {
        name: _number(name, value, parameters[name].type)
        for name, value in given.items()
        if value is not None or np.isnan(parameters[name].by_default)  # None leaves the parameter at the core's default
    }
    if sim is None:
        return _core.ImagingSonar(kind, figures)
    strengths_db, materials = _strengths_by_label(sim, model)
    return _core.ImagingSonar(kind, figures, strengths_db, materials)


def noise_db(model: Acoustics, core: _core.ImagingSonar, sim: Place, head_z_m: float) -> Levels:
    """Return the mean noise level after the time-varied gain in each range bin, (bins,)."""
    gain_db = np.zeros(model.range_bins)
    if model.time_varied_gain:
        absorption_db_m = core.absorption_db_m(sim.world.water, head_z_m)
        gain_db = model.gain_db_decade * np.log10(model.bin_centres_m) + 2.0 * absorption_db_m * model.bin_centres_m
    return (model.noise_level_db + gain_db).astype(np.float32)


def level_span(level_db: Levels) -> str:
    """Return the range of some levels as text, such as "20 to 95 dB"; levels that are not finite are left out."""
    known = level_db[np.isfinite(level_db)]
    return f"{known.min():.0f} to {known.max():.0f} dB" if known.size else "no levels"


def labels_of(arrays: Mapping[str, Levels], name: str = "labels") -> Labels | None:
    """Return the label of each cell from a ping's arrays, or None if labels were not requested."""
    return arrays[name].astype(np.uint16) if name in arrays else None


def whole_number(value: int, name: str) -> int:
    """Return a ping number as an int. Raises ValueError unless it is a non-negative whole number."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 0 <= value < 2**63:
        raise ValueError(f"{name} = {value!r}: must be a whole number, not negative")
    return int(value)


def _number(name: str, value: Any, type_name: str) -> float:
    """Return a parameter as a float; the core checks its range. Raises ValueError if it is not of the named type."""
    fits = isinstance(value, ACCEPTED[type_name]) and (type_name == "flag" or not isinstance(value, bool))
    if not fits:
        raise ValueError(f"sonar.{name} = {value!r}: must be a {type_name}")
    return float(value)


def _strengths_by_label(sim: Place, model: Acoustics) -> tuple[list[float], list[_core.BottomMaterial]]:
    """Return each surface's strength, from the model (by surface or class) or otherwise from its material.

    Also return each surface's material, which scatters by angle only if the model has no strength for the surface.
    """
    given_db, material_db = model.strengths_db, sim.strengths_db
    fixed = sim.world.label_names
    names = [*fixed, *(name for name in material_db if name not in fixed)]  # the vehicles come last
    unknown = sorted(set(given_db) - set(names[1:]))
    if unknown:
        raise ValueError(f"sonar.strengths_db['{unknown[0]}']: not in the world; there are: {', '.join(names[1:])}")
    for name, value in given_db.items():
        if isinstance(value, bool) or not isinstance(value, int | float | np.number) or np.isnan(value):
            raise ValueError(f"sonar.strengths_db['{name}'] = {value!r} dB: must be a number")
    strengths_db, materials = [], []
    known: Mapping[str, _core.BottomMaterial] = getattr(sim, "materials", {})  # a Place may have none
    for label, name in enumerate(names):
        own_db = model.bottom_strength_db if label <= TERRAIN_LABEL else model.solid_strength_db
        usual_db = own_db if own_db is not None else material_db.get(name, np.nan)
        strengths_db.append(float(given_db.get(name, usual_db)))
        material = known.get(name, _core.BottomMaterial())
        if own_db is not None or name in given_db:
            material = _core.BottomMaterial(
                material.strength_db, material.relief, None, material.fluid, material.ripples_rad
            )
        materials.append(material)
    return strengths_db, materials
