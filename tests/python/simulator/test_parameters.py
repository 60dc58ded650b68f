"""Changing a parameter equals starting with that value in the scenario; every parameter has an effect."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import pytest

from parameter_world import VARIANTS, observed, world
from uwsim import Scenario, Simulator
from uwsim.scenario.spec.water import ONE_WATER
from uwsim.simulator.parameters.tree import nodes

SEEN_ONLY = ("optics.", "station.", ".cameras.", ".lamps.")
OTHER: dict[str, Any] = {
    "water.sound_speed_equation": "medwin",
    "water.density_kg_m3": 1017.0,  # this and the next densities agree with their salinities
    "water.profile.surface.density_kg_m3": 1009.0,
    "water.profile.bottom.density_kg_m3": 1017.0,
    "water.profile.levels.0.density_kg_m3": 1007.0,
    "water.profile.levels.1.density_kg_m3": 1017.0,
    "water.profile.levels.1.salinity_psu": 22.0,
    "warnings.range_m": 1.0,
    "warnings.proximity_m": 0.1,
    "optics.jerlov": "5C",
    "rov.sonar.model": "em2040-04",
    "rov.sonar.mode": "physics",
    "rov.sonar.receivers": 2,
    "rov.sonar.frequency_hz": 300000.0,
    "auv.sonar.model": "em2040-04",
    "auv.sonar.receivers": 2,
    "auv.sonar.frequency_hz": 300000.0,
    "drop_out": 0.9,
    "range_max_m": 0.5,
    "readout_ms": 40.0,
    "range_min_m": 5.0,
    "usbl.range_max_m": 1.0,
    "altitude.range_max_m": 0.2,
    "deflection_max_deg": 2.0,
    "slipstream_of": "left",
    "port.range_max_m": 0.2,
    "dvl.range_max_m": 0.2,
    "detection_db": 99.0,
    "cutoff_v": 15.5,
    "rov.volume_m3": 0.7,
    "auv.volume_m3": 0.7,
    "shutter_ms": 900.0,
    "taper": 0.0,
    "limits": [-1e-4, 1e-4],
    "limits.low": 0.19,
    "limits.high": -0.19,
    "strengths_db": {"terrain": -10.0},
    "water.profile": {"kind": "linear", "surface": {"temperature_deg_c": 18}, "bottom": {"temperature_deg_c": 9}},
    "optics.coefficients": {"diffuse_attenuation": [1, 1, 1], "absorption": [1, 1, 1], "scattering": [2, 2, 2]},
}
"""Valid values that have an effect, where none can be derived from the current value."""


SERVED = (".kind", ".command_timeout_s", "goal_tolerance", "wire")
"""The latter three act on servers: test_watchdog.py, test_actions.py, test_paper.py."""
SAME = {
    "rov.sonar.model": "the models that it may be replaced by differ from it in physics mode alone",
    "rov.sensors.usbl.frequency_hz": "acts on arrivals that overlap; tests/cpp/sensors/test_sensors.cpp has some",
    "rov.sensors.usbl.hears_strongest": "the first arrival is the strongest; tests/cpp/sensors has others",
    "rov.sensors.usbl.shares_modem": "this world has no link; tests/python/link/test_link_usbl.py has one",
    "station.cameras.deck.shutter_ms": "the station's camera is at rest",
    "station.cameras.deck.readout_ms": "the station's camera is at rest",
    "auv.sonar.mode": "bending, which is on, is for physics mode alone",
}
"""Parameters whose effect cannot be shown here, with the reason."""


def names() -> list[Any]:
    found = []
    for variant, water in VARIANTS.items():
        for name, node in nodes(Scenario(**world(variant))).items():
            is_parameter = node.type is not None and not node.idle and not name.endswith(SERVED) and name not in SAME
            if is_parameter and (not variant or any(name.startswith(f"water.{part}") for part in water)):
                found.append(pytest.param(variant, name, id=f"{variant}:{name}"))
    return found


def other_value(sim: Simulator, name: str) -> Any:
    parameter = sim.parameters.describe(name)
    value = parameter.value
    given = [given for given in OTHER if name.endswith(given)]
    if given:
        return OTHER[max(given, key=len)]
    if parameter.type == "flag":
        return not value
    if parameter.type == "choice":
        return next(choice for choice in parameter.choices if choice != value)
    assert parameter.type in ("number", "whole number"), parameter
    assert parameter.low is not None and parameter.high is not None
    if parameter.type == "whole number":
        return value * 2
    v = value or 0
    near = (v * 1.3 + 0.05, v * 0.7 - 0.05, v * 0.8, v * 1.01, v * 0.99)
    return next(x for x in near if parameter.low <= x <= parameter.high)


def with_value(data: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    """Set the value that `key` names in a scenario's values, as a user would in the file."""
    at: Any = data
    if key == "water.profile":  # the profile provides these
        data["water"] = {name: item for name, item in data["water"].items() if name not in ONE_WATER}
    *above, last = [int(part[1:-1]) if part[0] == "[" else part for part in re.findall(r"\[\d+\]|[^.\[\]]+", key)]
    for part in above:
        at = at[part] if isinstance(at, list) else at.setdefault(part, {})
    at[last] = value
    return data


def seen_by(name: str) -> dict[str, bool]:
    return {"pictures": any(part in name for part in SEEN_ONLY), "imaging": ".imaging_sonars." in name}


@cache
def simulator(variant: str) -> Simulator:
    return Simulator(Scenario(**world(variant)), threads=1)


@cache
def unchanged(variant: str, **looks: bool) -> dict[str, bytes]:
    sim = simulator(variant)
    sim.reset()
    return observed(sim, **looks)


@pytest.mark.parametrize(("variant", "name"), names())
def test_a_change_is_as_a_scenario_that_says_so_and_has_an_effect(variant: str, name: str) -> None:
    looks = seen_by(name)
    before = unchanged(variant, **looks)
    sim = simulator(variant)
    sim.reset()
    value = other_value(sim, name)
    key = sim.parameters.describe(name).key
    sim.parameters[name] = value
    changed = observed(sim, **looks)
    said = observed(Simulator(Scenario(**with_value(world(variant), key, value)), threads=1), **looks)
    assert [what for what in said if changed[what] != said[what]] == []
    assert [what for what in said if changed[what] != before[what]] != [], f"{name} = {value} has no effect"
