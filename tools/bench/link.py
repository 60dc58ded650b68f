"""The cost of a link: a step of 20 vehicles with a link at full load, compared with a step without one.

Both alternate within one run, so that other load on the machine affects them equally; the median of the per-round
ratios is reported. Times are CPU times of the process, on one thread.
"""

from __future__ import annotations

import statistics
from functools import partial
from typing import Annotated, Any

import typer
from _harness import alternated, console, ratio, spent_s

from uwsim import Simulator
from uwsim.scenario import VehicleEntry, load
from uwsim.scenario.spec.vehicle import load_vehicle

VEHICLES = 20
LIMIT = 1.2
EFFORT = 0.2
MESSAGE_BYTES = 21  # the nine values of the panel


def main(
    rounds: Annotated[int, typer.Option(min=1, help="Rounds; medians over them are reported.")] = 11,
    steps: Annotated[int, typer.Option(min=1, help="Steps of each case in a round.")] = 2000,
    vehicle: Annotated[str, typer.Option(help="The vehicles' model.")] = "bluerov2_heavy",
) -> dict[str, Any]:
    """Measure all cases alternately and print the medians of their ratios to a step without a link."""
    cases = {"no link": Fleet(None, vehicle)}
    cases |= {modem: Fleet(modem, vehicle) for modem in ("ideal_acoustic", "s2cm_hs", "micromodem")}
    cases["s2cm_hs, aloha"] = Fleet("s2cm_hs", vehicle, access="aloha")
    times = alternated({name: partial(fleet.step_s, steps) for name, fleet in cases.items()}, rounds)
    results = {}
    for name, fleet in cases.items():
        share, us = ratio(times[name], times["no link"]), 1e6 * statistics.median(times[name])
        results[name] = {"step_us": us, "ratio": share, "delivered_per_s": fleet.delivered_per_s()}
        verdict = "" if name == "no link" else f", {'within' if share <= LIMIT else 'BEYOND'} {LIMIT:g}"
        console.print(
            f"{name:16s} {us:8.1f} us a step, {share:5.3f} of a step without{verdict}; "
            f"{results[name]['delivered_per_s']:.1f} messages a simulated second delivered"
        )
    return results


class Fleet:
    """Twenty vehicles in the lake, each of which sends the panel's message once a second."""

    def __init__(self, modem: str | None, model: str, *, access: str | None = None) -> None:
        scenario = load("lake")
        entry = VehicleEntry.model_validate(
            {"name": "x", "model": load_vehicle(model), "start": {"position_m": (0, 0, 0)}}
        )
        places = [(-90.0 + 12.0 * (k % 5), -60.0 + 12.0 * (k // 5), -8.0) for k in range(VEHICLES)]
        vehicles = tuple(
            entry.model_copy(
                update={"name": f"rov{k}", "start": entry.start.model_copy(update={"position_m": place})}  # type: ignore[union-attr]
            )
            for k, place in enumerate(places)
        )
        scenario = scenario.model_copy(update={"vehicles": vehicles})
        if modem is not None:
            scenario = scenario.with_changes(modem=modem)
            if access is not None and scenario.link is not None:
                scenario = scenario.model_copy(update={"link": scenario.link.model_copy(update={"access": access})})
        self._sim = Simulator(scenario, threads=1)
        for rov in self._sim.vehicles.values():
            rov.set_effort(surge=EFFORT)

    def step_s(self, steps: int) -> float:
        """Return the mean CPU time of a step; messages are submitted once per simulated second, outside the timing."""
        elapsed_s, sim = 0.0, self._sim
        per_second = round(1.0 / sim.step_s)
        for _ in range(max(1, steps // per_second)):
            if sim.link is not None:
                for name in sim.vehicles:
                    sim.link.send(name, "station", "state", bytes(MESSAGE_BYTES), priority=1, replaces=True)
            elapsed_s += spent_s(partial(sim.step, per_second))
        return elapsed_s / (max(1, steps // per_second) * per_second)

    def delivered_per_s(self) -> float:
        """Return the number of messages delivered per simulated second so far."""
        link = self._sim.link
        return 0.0 if link is None else sum(one.delivered for one in link.counts()) / self._sim.time_s
