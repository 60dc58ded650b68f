"""The cost of a link: a step of 20 vehicles with a link at full load, compared with a step without one.

CPU times of the process, on one thread. Each vehicle sends the panel's message once a second.
"""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

import typer
from _harness import Rounds, beside, lake_fleet, show, spent_s

from uwsim import Simulator

VEHICLES, MOST = 20, 1.2
MESSAGE_BYTES = 21  # the nine values of the panel


def main(
    rounds: Rounds = 11,
    steps: Annotated[int, typer.Option(min=1, help="Steps of each case in a round.")] = 2000,
    vehicle: Annotated[str, typer.Option(help="The vehicles' model.")] = "bluerov2_heavy",
) -> dict[str, Any]:
    """Measure all cases alternately and print the medians of their ratios to a step without a link."""
    fleets = {modem or "no link": fleet(modem, vehicle) for modem in (None, "ideal_acoustic", "s2cm_hs", "micromodem")}
    fleets["s2cm_hs, aloha"] = fleet("s2cm_hs", vehicle, access="aloha")
    cases = {name: partial(step_s, sim, steps) for name, sim in fleets.items()}
    results: dict[str, Any] = {"step": beside(f"a step of {VEHICLES} vehicles", cases, rounds, "no link", MOST)}
    results["delivered"] = {
        name: sum(each.delivered for each in sim.link.counts()) / sim.time_s for name, sim in fleets.items() if sim.link
    }
    show("messages delivered in a simulated second", results["delivered"])
    return results


def fleet(modem: str | None, model: str, access: str | None = None) -> Simulator:
    """Return twenty vehicles under way in the lake."""
    scenario = lake_fleet([(-90.0 + 12.0 * (k % 5), -60.0 + 12.0 * (k // 5), -8.0) for k in range(VEHICLES)], model)
    scenario = scenario.with_changes(modem=modem) if modem else scenario
    if access is not None and scenario.link is not None:
        scenario = scenario.model_copy(update={"link": scenario.link.model_copy(update={"access": access})})
    sim = Simulator(scenario, threads=1)
    for rov in sim.vehicles.values():
        rov.set_effort(surge=0.2)
    return sim


def step_s(sim: Simulator, steps: int) -> float:
    """Return the mean CPU time of a step; messages are submitted once per simulated second, outside the timing."""
    link, elapsed_s, per_second = sim.link, 0.0, round(1.0 / sim.step_s)
    seconds = max(1, steps // per_second)
    for _ in range(seconds):
        for name in sim.vehicles if link else ():
            assert link is not None
            link.send(name, "station", "state", bytes(MESSAGE_BYTES), priority=1, replaces=True)
        elapsed_s += spent_s(partial(sim.step, per_second))
    return elapsed_s / (seconds * per_second)
