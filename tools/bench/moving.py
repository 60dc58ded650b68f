"""Eight vehicles that move and ping together, on one thread and on two, by wall time."""

from __future__ import annotations

import time
from functools import partial
from typing import Annotated, Any

import typer
from _harness import Rounds, beside, spent_s

from uwsim import Simulator
from uwsim.scenario import load
from uwsim.scenario.spec.vehicle_entry import StartPose

SONAR_MODEL = 3  # 1,025 beams to 95 m
FLEET, STEPS = 8, 20  # vehicles, and the steps between their pings: 10 Hz


def main(
    rounds: Rounds = 11,
    pings: Annotated[int, typer.Option(min=1, help="Number of pings in a measurement.")] = 100,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    results: dict[str, Any] = {}
    for mode, count in (("geometry", pings), ("physics", max(pings // 10, 1))):
        cases = {f"{threads} threads": partial(move_and_ping_s, fleet(mode, threads), count) for threads in (2, 1)}
        title = f"{FLEET} vehicles, {STEPS} steps and a ping of each in {mode} mode"
        results[mode] = beside(title, cases, rounds, "2 threads")
    return results


def fleet(mode: str, threads: int) -> Simulator:
    """Return vehicles side by side over the lake, with their sonars aimed at the bed."""
    scenario = load("lake").with_changes(sonar_model=SONAR_MODEL)
    first = scenario.vehicles[0]
    first = first.model_copy(update={"sonar": first.sonar.model_copy(update={"mode": mode})})
    start = StartPose(position_m=(-104.0, -28.0, -1.0))  # positioned below
    others = [first.model_copy(update={"name": f"other_{k}", "start": start}) for k in range(FLEET - 1)]
    sim = Simulator(scenario.model_copy(update={"vehicles": (first, *others)}), threads=threads)
    for k, vehicle in enumerate(sim.vehicles.values()):
        vehicle.place((-104.0 + 5.0 * k, -28.0, -4.0))
        vehicle.set_effort(surge=0.1, yaw=0.1)
        vehicle.sonar.aim(-1.2)
    sim.advance(10.0)  # until the heads have turned
    return sim


def move_and_ping_s(sim: Simulator, count: int) -> float:
    """Return the wall time of some steps and a ping of each vehicle."""
    sonars = [vehicle.sonar for vehicle in sim.vehicles.values()]

    def run() -> None:
        for _ in range(count):
            sim.step(STEPS)
            sim.ping(*sonars)

    return spent_s(run, time.perf_counter) / count
