"""The world's labels: the number that rays return for each surface, and how that surface scatters sound."""

from __future__ import annotations

from uwsim.scenario.spec.material import ROCK, Backscatter
from uwsim.scenario.spec.scenario import Scenario


def label_names(scenario: Scenario) -> list[str]:
    """The names, by label, of the world that `build_world` makes: equal to its World.label_names."""
    station = ["station"] if scenario.station.mesh is not None else []
    return ["nothing", "terrain", *(obstacle.name for obstacle in scenario.obstacles), *station]


def backscatter_by_label(scenario: Scenario) -> list[Backscatter]:
    """The backscatter of the surface with each label, in the order of `label_names`."""
    station = [scenario.station.material] if scenario.station.mesh is not None else []
    solids = [obstacle.material for obstacle in scenario.obstacles] + station
    return [ROCK, scenario.ground.backscatter, *(material.backscatter for material in solids)]
