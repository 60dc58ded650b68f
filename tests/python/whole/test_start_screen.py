"""The choices of the start screen can be flown, each at least once."""

from collections.abc import Iterator
from functools import cache
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


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_every_scenario_is_chosen(scenario: str) -> None:
    """That it flies, with any of the vehicles, is in evidence/test_scenario_check.py."""
    made, _ = chosen({"scenario": scenario, "vehicle": VEHICLES[0], "sonar": SONARS[-1], "link": LINKS[-1]})
    assert (made.name, made.vehicles[0].model.name) == (scenario, VEHICLES[0])


def test_each_choice_of_each_field_flies() -> None:
    kept = Simulator("pool", threads=1)  # simulators of one world share its ray trees while one is there
    rounds = max(map(len, CHOICES.values()))
    for n in range(rounds):
        fly(("pool", *(of[n % len(of)] for name, of in CHOICES.items() if name != "scenario")))
    del kept
