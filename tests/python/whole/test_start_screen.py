"""The choices of the start screen can be flown: every pair of two at least once, a few steps each.

All combinations are flown under `tools/test --all`.
"""

import gc
from collections.abc import Iterator
from functools import cache
from itertools import combinations, product
from typing import Any, get_args

import pytest

from uwsim import _core
from uwsim.channels.served import served_table
from uwsim.channels.table import Wire
from uwsim.link import Carrier
from uwsim.live import LiveSimulator
from uwsim.operator.station.start.choice import catalog, chosen
from uwsim.scenario import Scenario, load, load_vehicle
from uwsim.scenario.build import world
from uwsim.scenario.build.terrain import Terrain
from uwsim.scenario.read.collected import Collected
from uwsim.scenario.spec.terrain import TerrainModel
from uwsim.simulator.simulator import Simulator

OFFERED = catalog()
SCENARIOS, VEHICLES, SONARS, LINKS = (
    [each["name"] for each in OFFERED[key]] for key in ("scenarios", "vehicles", "sonars", "links")
)
CHOICES: dict[str, list[Any]] = {
    "scenario": SCENARIOS, "vehicle": [None, *VEHICLES], "sonar": [None, *SONARS], "link": LINKS,
    "wire": list(get_args(Wire)),
}  # fmt: skip


@pytest.fixture(autouse=True, scope="module")
def built_once() -> Iterator[None]:
    """Build each world once, however often its scenario is flown: vehicles must fit into it, nothing else is chosen."""
    build, last = world.build_terrain, dict[str, Any](spec=None, name=None)

    def terrain_once(spec: TerrainModel) -> Terrain:
        if last["spec"] != spec:
            last.update(spec=spec, terrain=build(spec))
        return last["terrain"]

    def world_once(scenario: Scenario) -> _core.World:
        if last["name"] != scenario.name:
            last.update(world=world.build_world(scenario), name=scenario.name)
        found, terrain = Collected(), terrain_once(scenario.terrain)
        world._require_inside(scenario, terrain.window(scenario.terrain.window_m), found)
        world._require_free_starts(last["world"], terrain, scenario, found)
        found.raise_any()
        return last["world"]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(world, "build_terrain", terrain_once)
        patch.setattr("uwsim.simulator.simulator.build_world", world_once)
        for read in (load, load_vehicle):
            patch.setattr(f"uwsim.operator.station.start.choice.{read.__name__}", cache(read))
        yield


def pairwise() -> Iterator[tuple[Any, ...]]:
    """Yield combinations in which all pairs occur: the k-th scenario's n-th has the (k by + n)-th of each choice."""
    steps = {"vehicle": 0, "sonar": 1, "link": 2, "wire": 2}
    for (k, scenario), n in product(enumerate(SCENARIOS), range(max(len(CHOICES["vehicle"]), len(CHOICES["sonar"])))):
        yield (scenario, *(CHOICES[key][(k * by + n) % len(CHOICES[key])] for key, by in steps.items()))


def fly(choice: tuple[Any, ...]) -> None:
    """Start what the start screen would start, and fly it for a moment."""
    *fields, wire = choice
    scenario, _ = chosen(dict(zip(CHOICES, fields, strict=False)))
    sim = Simulator(scenario, threads=1)
    table = served_table(LiveSimulator(sim, paused=True), wire=wire)
    if sim.link is not None:
        Carrier(sim, table)
    for name, vehicle in sim.vehicles.items():
        vehicle.release()
        vehicle.set_effort(heave=-0.1)
        sim.step(2)
        assert vehicle.telemetry().depth_m < 1e3, name
        for sonar in vehicle.sonars.values():
            sonar.ping()


def failures(choices: Iterator[tuple[Any, ...]]) -> list[str]:
    """Return a line for each combination that cannot be flown."""
    found = []
    for choice in choices:
        try:
            fly(choice)
        except ValueError as error:
            found.append(f"{choice}: {error}")
    gc.collect()
    return found


def test_every_pair_is_among_the_combinations() -> None:
    flown = list(pairwise())
    for (a, one), (b, other) in combinations(enumerate(CHOICES.values()), 2):
        assert {(each[a], each[b]) for each in flown} == set(product(one, other))


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_each_pair_of_choices_flies(scenario: str) -> None:
    kept = Simulator(scenario, threads=1)  # simulators of one world share its ray trees while one is there
    assert failures(each for each in pairwise() if each[0] == scenario) == []
    del kept


@pytest.mark.exhaustive
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_each_combination_of_choices_flies(scenario: str) -> None:
    kept = Simulator(scenario, threads=1)
    assert failures(each for each in product(*CHOICES.values()) if each[0] == scenario) == []
    del kept
