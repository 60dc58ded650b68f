"""Labels of the surfaces that rays hit, in the world and on vehicles, and their acoustic backscatter."""

from __future__ import annotations

from uwsim.scenario.build.arm import all_shaped_links
from uwsim.scenario.build.bubbles import plume_names
from uwsim.scenario.build.tether import tether_specs
from uwsim.scenario.spec.bubble_plume import BUBBLES
from uwsim.scenario.spec.material import ROCK, TETHER, Backscatter
from uwsim.scenario.spec.scenario import Scenario


def label_names(scenario: Scenario) -> list[str]:
    """Return the names by label: World.label_names, vehicles, objects, life, plumes, links of arms, then tethers.

    An arm has a label for each link with a shape, `<vehicle> <shape>`, and a tether one for each of its elements, all
    with the name `<vehicle or object> tether`.
    """
    station = ["station"] if scenario.station.mesh is not None else []
    parts = (scenario.obstacles, scenario.cover, scenario.vehicles, scenario.objects, scenario.life or ())
    obstacles, cover, vehicles, objects, life = ([named.name for named in part] for part in parts)
    arms = [f"{body} {link.shape.name}" for body, link in all_shaped_links(scenario) if link.shape is not None]
    fixed = ["nothing", "terrain", *obstacles, *station, *cover]
    return [*fixed, *vehicles, *objects, *life, *plume_names(scenario), *arms, *_tethers(scenario)]


def backscatter_by_label(scenario: Scenario) -> list[Backscatter]:
    """Return the backscatter of each labelled surface, in the order of `label_names`."""
    station = [scenario.station.material] if scenario.station.mesh is not None else []
    vehicles = [vehicle.model.material for vehicle in scenario.vehicles]
    vehicles += [body.shape.material for body in scenario.objects]
    vehicles += [animals.material for animals in scenario.life or ()]
    vehicles += [BUBBLES for _ in plume_names(scenario)]
    vehicles += [link.shape.material for _, link in all_shaped_links(scenario) if link.shape is not None]
    obstacles, cover = [one.surface for one in scenario.obstacles], [layer.material for layer in scenario.cover]
    solids = (material.backscatter for material in (*obstacles, *station, *cover, *vehicles))
    tethers = [TETHER] * len(_tethers(scenario))
    return [ROCK, scenario.ground.backscatter, *solids, *tethers]


def _tethers(scenario: Scenario) -> list[str]:
    return [f"{name} tether" for name, spec in tether_specs(scenario).items() for _ in range(spec.tubes)]
