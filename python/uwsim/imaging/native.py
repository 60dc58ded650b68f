"""From a model and a simulator to the native core's model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Protocol

import numpy as np

from uwsim import _core
from uwsim.imaging.models import Acoustics, ForwardLooking, SideScan, SingleBeam

_TERRAIN = 1  # the label


class Place(Protocol):
    """What a sonar needs of a simulator."""

    @property
    def scene(self) -> _core.RayScene:
        """The surfaces that echo."""

    @property
    def world(self) -> _core.World:
        """Its water is heard through."""

    @property
    def strengths_db(self) -> Mapping[str, float]:
        """Lambert's strength of each surface, by World.label_names, as what it is made of has it."""

    @property
    def seed(self) -> int:
        """Of the speckle."""

    @property
    def threads(self) -> int:
        """How many may be used; what is heard does not depend on it."""

    @property
    def time_ns(self) -> int:
        """Simulated time."""


def check(model: Acoustics, sim: Place | None = None) -> None:
    """Raise ValueError, naming the field, for a model that is none; with a sim, of strengths_db too."""
    core_model(sim, model)


_CORE_MODELS: dict[type[Acoustics], Any] = {
    ForwardLooking: _core.ForwardLookingModel, SideScan: _core.SideScanModel, SingleBeam: _core.SingleBeamModel
}  # fmt: skip


def core_model(sim: Place | None, model: Acoustics, expected: type[Acoustics] = Acoustics) -> Any:
    """Fill the native model: each field goes by its name, to the acoustics or to the rest. Raises ValueError."""
    acoustics = _core.ImagingAcoustics()
    core = next((make() for kind, make in _CORE_MODELS.items() if isinstance(model, kind)), None)
    if core is None or not isinstance(model, expected):
        raise ValueError(f"model is a {type(model).__name__}: must be a {expected.__name__} of uwsim.imaging")
    for entry in fields(model):
        name, value = entry.name, getattr(model, entry.name)
        if name == "strengths_db":
            if not isinstance(value, Mapping):
                raise ValueError(f"sonar.strengths_db = {value!r}: must be dB by name")
            continue
        if name in ("bottom_strength_db", "solid_strength_db") and value is None:
            continue
        target = acoustics if hasattr(acoustics, name) else core
        try:
            setattr(target, name, value)
        except TypeError as error:
            kind = type(getattr(target, name)).__name__
            raise ValueError(f"sonar.{name} = {value!r}: must be of type {kind}") from error
    if sim is not None:
        acoustics.strengths_db = _strengths_by_label(sim, model)
    core.acoustics = acoustics
    core.check()
    return core


def _strengths_by_label(sim: Place, model: Acoustics) -> list[float]:
    """The model's for single ones, else its for the terrain or all solids, else the material's."""
    names, given_db, material_db = sim.world.label_names, model.strengths_db, sim.strengths_db
    unknown = sorted(set(given_db) - set(names[1:]))
    if unknown:
        raise ValueError(f"sonar.strengths_db['{unknown[0]}']: not in the world; there are: {', '.join(names[1:])}")
    for name, value in given_db.items():
        if isinstance(value, bool) or not isinstance(value, int | float | np.number) or np.isnan(value):
            raise ValueError(f"sonar.strengths_db['{name}'] = {value!r} dB: must be a number")
    strengths_db = []
    for label, name in enumerate(names):
        own_db = model.bottom_strength_db if label <= _TERRAIN else model.solid_strength_db
        usual_db = own_db if own_db is not None else material_db.get(name, np.nan)
        strengths_db.append(float(given_db.get(name, usual_db)))
    return strengths_db
