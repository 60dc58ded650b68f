"""Replacement of values in a scenario, with the result validated as a whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.sensor import Noise, SensorMount
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.water import ONE_WATER, Water
from uwsim.simulator.parameters.effective import effective, sensor_figures
from uwsim.simulator.parameters.tree import Place

KIND = "kind"
UNSET = object()


@dataclass
class Edits:
    """The replacement values at and below a key path."""

    value: Any = UNSET
    below: dict[str | int, Edits] = field(default_factory=dict)

    def put(self, place: Place, value: Any) -> None:
        """Replace the value at a path below this one."""
        at = self
        for part in place:
            at = at.below.setdefault(part, Edits())
        at.value = value


def edited(scenario: Scenario, changes: Mapping[Place, Any]) -> Scenario:
    """Return a validated copy with these values. Raises a ScenarioError that names the scenario's keys."""
    edits = Edits()
    for place, value in changes.items():
        edits.put(place, value)
    copy = validated(Scenario, _Merge(scenario).merged(scenario, edits))
    for before, after in zip(scenario.vehicles, copy.vehicles, strict=True):
        after.model._source_file = before.model.source_file
    return copy


@dataclass(frozen=True)
class _Merge:
    scenario: Scenario

    def merged(self, present: Any, edits: Edits) -> Any:
        """Return plain values for a model: the current ones with the edits applied; unedited parts remain models."""
        value = present if edits.value is UNSET else edits.value
        if not edits.below:
            return value
        if isinstance(value, Model):
            return self._merged_model(value, edits)
        if isinstance(value, Mapping) or value is None:
            own = dict(value or {})
            return own | {key: self.merged(own.get(key), below) for key, below in edits.below.items()}
        if not isinstance(value, tuple | list):
            raise ScenarioError(f"{next(iter(edits.below))}: no such part of a value that has none")
        items = list(value)
        for k, below in edits.below.items():
            if not isinstance(k, int) or not 0 <= k < len(items):
                raise ScenarioError(f"{k}: no such item: there are {len(items)}")
            items[k] = self.merged(items[k], below)
        return items

    def _merged_model(self, model: Model, edits: Edits) -> dict[str | int, Any]:
        data: dict[Any, Any] = model.given()
        kind = edits.below.get(KIND)
        if kind is not None and kind.value != getattr(model, KIND, None):
            data = {}  # a different kind has different keys
        for key, below in edits.below.items():
            data[key] = self.merged(self._base(model, str(key)), below)
        for key in _displaced(model, data, edits):
            data.pop(key, None)
        return data

    def _base(self, model: Model, key: str) -> Any:
        """Return the value to which an edit below a field is applied."""
        if isinstance(model, SensorMount) and key == "noise":
            return model.noise or Noise(std=model.noise_std or 0.0)
        if isinstance(model, SensorMount) and key not in SensorMount.model_fields:
            return sensor_figures(model)[key][1]
        own = getattr(model, key, None)
        return effective(model, key, self.scenario) if own is None and isinstance(model, VehicleModel) else own


def _displaced(model: Model, data: Mapping[str | int, Any], edits: Edits) -> tuple[str, ...]:
    """Return the keys that the edits displace, where a scenario may specify only one of two alternatives."""
    if isinstance(model, VehicleModel) and "mass_kg" in edits.below:
        return "density_kg_m3", "buoyancy"
    if isinstance(model, SensorMount) and "noise" in edits.below:
        return ("noise_std",)
    if isinstance(model, Water) and "profile" in edits.below and data.get("profile") is not None:
        return tuple(key for key in ONE_WATER if key not in edits.below)
    return ()
