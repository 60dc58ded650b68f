"""The labels that rays return for the surfaces of the world and its vehicles, and how those surfaces scatter sound."""

from __future__ import annotations

from uwsim.scenario.spec.material import ROCK, Backscatter
from uwsim.scenario.spec.scenario import Scenario


def label_names(scenario: Scenario) -> list[str]:
    """The names by label: those of the world that `build_world` makes (World.label_names), then the vehicles'."""
    station = ["station"] if scenario.station.mesh is not None else []
    obstacles, vehicles = ([named.name for named in part] for part in (scenario.obstacles, scenario.vehicles))
    return ["nothing", "terrain", *obstacles, *station, *vehicles]


def backscatter_by_label(scenario: Scenario) -> list[Backscatter]:
    """The backscatter of the surface with each label, in the order of `label_names`."""
    station = [scenario.station.material] if scenario.station.mesh is not None else []
    vehicles = [vehicle.model.material for vehicle in scenario.vehicles]
    solids = [obstacle.material for obstacle in scenario.obstacles] + station + vehicles
    return [ROCK, scenario.ground.backscatter, *(material.backscatter for material in solids)]
