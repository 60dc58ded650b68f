"""Reads scenarios in old recordings, which contain all fields of all models, whether or not they had been set.

In such scenarios, the presence of a key has no meaning. Keys whose presence matters are therefore removed if they have
their default value, so that the scenario is built as it was for the recording. It is impossible to determine whether a
value of `sonar.noise` or `link.carries` had been set to its default explicitly.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from uwsim.base.axes import AXES
from uwsim.scenario.dump import plain
from uwsim.scenario.spec.control import Control
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.link import LinkSetup
from uwsim.scenario.spec.sonar import SonarNoise

PRESENCE: dict[tuple[str, ...], tuple[type[Model], tuple[str, ...]]] = {
    ("vehicles", "model", "control"): (Control, AXES),
    ("vehicles", "sonar", "noise"): (SonarNoise, tuple(SonarNoise.model_fields)),
    ("link",): (LinkSetup, ("carries",)),
}
"""The keys whose presence matters, by path. Lists are traversed."""
BESIDE_PROFILE = ("density_kg_m3", "surface_temperature_deg_c", "bottom_temperature_deg_c", "salinity_psu")
"""Keys of `water` that cannot have been set in a scenario with a profile."""


def without_defaults(scenario: Any) -> Any:
    """Remove the keys of PRESENCE that have default values from an old scenario, in place, and return the scenario."""
    for path, (model, keys) in PRESENCE.items():
        defaults = {key: _every_field(model.model_fields[key].default) for key in keys}
        for values in _at(scenario, path):
            for key, default in defaults.items():
                if key in values and values[key] == default:
                    del values[key]
    for water in _at(scenario, ("water",)):
        if water.get("profile") is not None:
            for key in BESIDE_PROFILE:
                water.pop(key, None)
    return scenario


def _every_field(value: Any) -> Any:
    return plain(dict(value)) if isinstance(value, Model) else plain(value)


def _at(value: Any, path: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    if isinstance(value, list):
        for item in value:
            yield from _at(item, path)
    elif isinstance(value, dict):
        if not path:
            yield value
        elif path[0] in value:
            yield from _at(value[path[0]], path[1:])
