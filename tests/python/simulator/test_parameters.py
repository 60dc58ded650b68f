"""Changing a parameter equals starting with that value in the scenario; every parameter has an effect."""

from __future__ import annotations

import re
from collections import defaultdict
from functools import cache
from itertools import zip_longest
from typing import Any

import pytest

from parameter_world import VARIANTS, observed, watched, world
from uwsim import Scenario, Simulator
from uwsim.scenario.spec.water import ONE_WATER
from uwsim.simulator.parameters.tree import nodes

VEHICLES = ("rov", "auv")
SEVERAL = ("sensors", "imaging_sonars", "thrusters")
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
    "optics.fetch_m": 25.0,
    "optics.coefficients": {"diffuse_attenuation": [1, 1, 1], "absorption": [1, 1, 1], "scattering": [2, 2, 2]},
}
"""Valid values that have an effect, where none can be derived from the current value."""


SERVED = (".kind", ".command_timeout_s", "goal_tolerance", "wire")
"""The latter three act on servers: test_watchdog.py, test_actions.py, test_nodes.py."""
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


@cache
def owners(variant: str) -> dict[str, list[str]]:
    """Return the names of all parameters by what they belong to: the water, or a part of a vehicle."""
    found = defaultdict(list)
    for name, node in nodes(Scenario(**world(variant))).items():
        is_parameter = node.type is not None and not node.idle and not name.endswith(SERVED) and name not in SAME
        if is_parameter and (not variant or any(name.startswith(f"water.{part}") for part in VARIANTS[variant])):
            first, *rest = name.split(".")
            deeper = rest[: 2 if rest[0] in SEVERAL else 1] if first in VEHICLES else []
            found[".".join([first, *deeper])].append(name)
    return dict(found)


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
def unchanged(variant: str, **looks: bool) -> list[tuple[str, bytes]]:
    sim = simulator(variant)
    sim.reset()
    return list(watched(sim, **looks))


@pytest.mark.parametrize(("variant", "owner"), [(variant, owner) for variant in VARIANTS for owner in owners(variant)])
def test_every_parameter_has_an_effect(variant: str, owner: str) -> None:
    sim, without = simulator(variant), {}
    for name in owners(variant)[owner]:
        sim.reset()
        value = other_value(sim, name)
        sim.parameters[name] = value
        looks = seen_by(name)
        seen = zip(watched(sim, **looks), unchanged(variant, **looks), strict=True)
        if all(found == before for found, before in seen):
            without[name] = value
    assert without == {}


@pytest.mark.parametrize("variant", VARIANTS)
def test_changes_are_as_a_scenario_that_has_them(variant: str) -> None:
    """One parameter of each owner at a time, so that none hides another."""
    sim = simulator(variant)
    for changed in zip_longest(*owners(variant).values()):
        sim.reset()
        values = {name: other_value(sim, name) for name in changed if name is not None}
        data = world(variant)
        for name, value in values.items():
            data = with_value(data, sim.parameters.describe(name).key, value)
        sim.parameters.update(values)
        looks = {look: any(seen_by(name)[look] for name in values) for look in ("pictures", "imaging")}
        begun = Simulator(Scenario(**data), threads=1)
        seen, expected = (observed(each, **looks) for each in (sim, begun))
        assert [what for what in expected if seen[what] != expected[what]] == [], values
