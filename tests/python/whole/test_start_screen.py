"""The choices of the start screen can be flown: each at least once, and each vehicle over each link and wire.

All combinations are flown under `tools/test --all`.
"""

from collections.abc import Iterator
from functools import cache
from itertools import product
from typing import Any, get_args

import pytest

from uwsim.channels.served import served_table
from uwsim.channels.table import Wire
from uwsim.link import Carrier
from uwsim.live import LiveSimulator
from uwsim.operator.station.start.choice import catalog, chosen
from uwsim.scenario import load, load_vehicle
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
def read_once() -> Iterator[None]:
    """Read each scenario's file and each vehicle's once, however often it is chosen."""
    with pytest.MonkeyPatch.context() as patch:
        for read in (load, load_vehicle):
            patch.setattr(f"uwsim.operator.station.start.choice.{read.__name__}", cache(read))
        yield


def nth(of: str, n: int) -> Any:
    """Return one of the choices of a field, round and round."""
    return CHOICES[of][n % len(CHOICES[of])]


SERVED = [
    ("pool", vehicle, nth("sonar", len(LINKS) * k + n), link, nth("wire", k + n))
    for (k, vehicle), (n, link) in product(enumerate(CHOICES["vehicle"]), enumerate(LINKS))
]
"""Each vehicle with each link and each wire."""


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


def test_every_choice_is_among_those_that_are_flown() -> None:
    for k, of in enumerate([*CHOICES][1:], 1):
        assert {each[k] for each in SERVED} == {*CHOICES[of]}
    assert {(each[1], each[4]) for each in SERVED} == {*product(CHOICES["vehicle"], CHOICES["wire"])}


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_every_scenario_is_chosen(scenario: str) -> None:
    """That it flies, with any of the vehicles, is in evidence/test_scenario_check.py."""
    made, _ = chosen({"scenario": scenario, "vehicle": VEHICLES[0], "sonar": SONARS[-1], "link": LINKS[-1]})
    assert (made.name, made.vehicles[0].model.name) == (scenario, VEHICLES[0])


def test_each_vehicle_is_served_over_each_link_and_wire() -> None:
    kept = Simulator("pool", threads=1)  # simulators of one world share its ray trees while one is there
    for choice in SERVED:
        fly(choice)
    del kept


@pytest.mark.exhaustive
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_each_combination_of_choices_flies(scenario: str) -> None:
    kept = Simulator(scenario, threads=1)
    for others in product(*[*CHOICES.values()][1:]):
        fly((scenario, *others))
    del kept
