"""The cost of other vehicles for a ping: alone in the lake, among 20, and with all 20 close to the sonar.

The cases alternate, each round at the same positions; medians of the per-round ratios of one thread's processor time
are reported. Then eight vehicles move and ping together, on one thread and on two: the ratio of their wall times.
"""

from __future__ import annotations

import time
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer
from _harness import alternated, console, medians, ratio
from numpy.typing import NDArray
from rich.table import Table

from uwsim import Simulator
from uwsim.scenario import load
from uwsim.scenario.spec.vehicle_entry import StartPose

SONAR_MODEL = 3  # 1,025 beams to 95 m
LINE_M = ((-104.0, -28.0), (-44.0, -28.0))
ALTITUDE_M = 8.0
GOAL = 1.3  # maximum ratio, among the others
FLEET, STEPS = 8, 20  # vehicles that ping together, and the steps between their pings: 10 Hz
FLEET_GOAL = 1.8


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often each case is measured.")] = 11,
    pings: Annotated[int, typer.Option(min=1, help="Number of pings in a measurement.")] = 100,
    others: Annotated[int, typer.Option(min=1, max=200, help="Number of other vehicles.")] = 20,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    table = Table("mode", "case", "us per ping", "of alone", "beams on vehicles", title="Pings among other vehicles")
    results: dict[str, float] = {}
    for mode in ("geometry", "physics"):
        alone, among, close = (lake(mode, count) for count in (0, others, others))
        places = line(alone, pings if mode == "geometry" else max(pings // 10, 1))
        scatter(among, places)
        gather(close, places)
        cases = {"alone": alone, "among": among, "close": close}
        found = alternated({name: partial(measure, sim, places) for name, sim in cases.items()}, rounds)
        rounds_us = {name: [us for us, _ in each] for name, each in found.items()}
        for name, us in medians(rounds_us).items():
            of_alone = ratio(rounds_us[name], rounds_us["alone"])
            results |= {f"{mode}_{name}_us": us, f"{mode}_{name}/alone": of_alone}
            table.add_row(mode, name, f"{us:,.0f}", f"{of_alone:.2f}", f"{found[name][0][1]:.0f}")
    console.print(table)
    met = results["geometry_among/alone"] <= GOAL and results["physics_among/alone"] <= GOAL
    console.print(f"among the others at most {GOAL} times: {'[green]yes[/]' if met else '[red]no[/]'}")
    for mode, count in (("geometry", pings), ("physics", max(pings // 10, 1))):
        fleets = {f"{threads}": partial(move_and_ping, fleet(mode, threads), count) for threads in (1, 2)}
        ms = alternated(fleets, rounds)
        results[f"{mode}_fleet_1/2"] = gain = ratio(ms["1"], ms["2"])
        middle = medians(ms)
        console.print(
            f"{FLEET} vehicles in {mode} mode, {STEPS} steps and a ping of each: {middle['1']:.2f} ms on one thread, "
            f"{middle['2']:.2f} on two; {gain:.2f} times as fast (goal: {FLEET_GOAL})"
        )
    return results


def fleet(mode: str, threads: int) -> Simulator:
    """Return vehicles side by side over the lake, with their sonars aimed at the bed."""
    sim = Simulator(lake(mode, FLEET - 1).scenario, threads=threads)
    for k, vehicle in enumerate(sim.vehicles.values()):
        vehicle.place((LINE_M[0][0] + 5.0 * k, LINE_M[0][1], -4.0))
        vehicle.set_effort(surge=0.1, yaw=0.1)
        vehicle.sonar.aim(-1.2)
    sim.advance(10.0)  # until the heads have turned
    return sim


def move_and_ping(sim: Simulator, count: int) -> float:
    """Return the milliseconds of wall time for some steps and a ping of each vehicle."""
    sonars = [vehicle.sonar for vehicle in sim.vehicles.values()]
    begun = time.perf_counter()
    for _ in range(count):
        sim.step(STEPS)
        sim.ping(*sonars)
    return 1e3 * (time.perf_counter() - begun) / count


def lake(mode: str, others: int) -> Simulator:
    """Return the lake with a sonar in this mode, and other vehicles of the same kind."""
    scenario = load("lake").with_changes(sonar_model=SONAR_MODEL)
    first = scenario.vehicles[0]
    first = first.model_copy(update={"sonar": first.sonar.model_copy(update={"mode": mode})})
    start = StartPose(position_m=(*LINE_M[0], -1.0))  # positioned later
    more = [first.model_copy(update={"name": f"other_{k}", "start": start}) for k in range(others)]
    return Simulator(scenario.model_copy(update={"vehicles": (first, *more)}))


def line(sim: Simulator, count: int) -> NDArray[np.float64]:
    """Return positions (count, 3) along a line at the survey's altitude above the bed."""
    xy = np.linspace(*LINE_M, count)
    return np.column_stack([xy, np.minimum(sim.world.height_at(xy) + ALTITUDE_M, -1.0)])


def scatter(sim: Simulator, places: NDArray[np.float64]) -> None:
    """Scatter the other vehicles over the water that the pings pass through."""
    random = np.random.default_rng(2)
    for vehicle in list(sim.vehicles.values())[1:]:
        xy = places[random.integers(len(places)), :2] + random.uniform(-30.0, 30.0, 2)
        bed_m = float(sim.world.height_at(xy[None])[0])
        vehicle.place((*xy, min(bed_m + random.uniform(2.0, 12.0), -1.0)))


def gather(sim: Simulator, places: NDArray[np.float64]) -> None:
    """Place the other vehicles side by side in the sonar's fan, at the centre of the line."""
    sim.rov.place(places[len(places) // 2])
    ping = sim.rov.sonar.ping()
    head, others = ping.world_from_sonar, list(sim.vehicles.values())[1:]
    for k, vehicle in enumerate(others):
        angle = np.radians(110.0) * ((k + 0.5) / len(others) - 0.5)
        vehicle.place(head[:3, 3] + 7.0 * (np.cos(angle) * head[:3, 0] + np.sin(angle) * head[:3, 1]))


def measure(sim: Simulator, places: NDArray[np.float64]) -> tuple[float, float]:
    """Return microseconds per ping, and the mean number of its beams that hit vehicles."""
    elapsed_s, beams, sonar = 0.0, 0, sim.rov.sonar
    vehicles_from = len(sim.world.label_names)
    for place in places:
        sim.rov.place(place)
        begun = time.thread_time()
        ping = sonar.ping()
        elapsed_s += time.thread_time() - begun
        beams += int((ping.labels >= vehicles_from).sum())
    return 1e6 * elapsed_s / len(places), beams / len(places)
