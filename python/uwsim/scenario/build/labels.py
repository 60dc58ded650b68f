"""Labels of the surfaces that rays hit, in the world and on vehicles, and their acoustic backscatter."""

from __future__ import annotations

from uwsim.scenario.spec.material import ROCK, Backscatter
from uwsim.scenario.spec.scenario import Scenario


def label_names(scenario: Scenario) -> list[str]:
    """Return the names by label: those from `build_world` (World.label_names), followed by those of the vehicles."""
    station = ["station"] if scenario.station.mesh is not None else []
    obstacles, vehicles = ([named.name for named in part] for part in (scenario.obstacles, scenario.vehicles))
    return ["nothing", "terrain", *obstacles, *station, *vehicles]


def backscatter_by_label(scenario: Scenario) -> list[Backscatter]:
    """Return the backscatter of each labelled surface, in the order of `label_names`."""
    station = [scenario.station.material] if scenario.station.mesh is not None else []
    vehicles = [vehicle.model.material for vehicle in scenario.vehicles]
    solids = [obstacle.material for obstacle in scenario.obstacles] + station + vehicles
    return [ROCK, scenario.ground.backscatter, *(material.backscatter for material in solids)]
