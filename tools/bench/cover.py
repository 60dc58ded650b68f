"""The cost of cover and of fish: pictures, pings and starts of covered scenarios, against a bare scenario's.

The cases alternate within each round, so that other load on the machine affects all of them equally; medians of one
thread's processor time, and of the per-round ratios, are reported. Pictures of 256 x 256 pixels are taken at fixed
places 1.2 to 3 m above the bed, with the nose 45 degrees down; pings 2.5 to 4.5 m above it, with the vehicle level. A
start is a new process that loads the scenario and makes one ping. The school is placed in the fan of a bare scenario.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer
from _harness import alternated, child, console, goal_cells, medians, new_table, ratio, result_of
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.scenario import Scenario, load
from uwsim.scenario.read.validated import validated

GOALS = {"picture": 1.7, "ping": 1.4, "start": 2.0, "school": 1.3}
"""The largest ratios to the bare scenario."""
PICTURES, PINGS, SIZE, FISH = 5, 20, 256, 200
Places = list[tuple[NDArray[np.float64], NDArray[np.float64]]]  # position (3,) [m], orientation (4,) xyzw


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often each case is measured.")] = 7,
    scenarios: Annotated[str, typer.Option(help="Covered scenarios, separated by commas.")] = "reef,wreck,kelp",
    bare: Annotated[str, typer.Option(help="The scenario that they are compared with.")] = "lake",
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    names = [bare, *scenarios.split(",")]
    cases: dict[tuple[str, str], Callable[[], float]] = {}
    for name in names:
        sim = Simulator(name, threads=1)
        sim.rov.release()
        cases["picture", name] = partial(picture_s, sim, places(sim, PICTURES, (1.2, 3.0), 45))
        cases["ping", name] = partial(ping_s, sim, places(sim, PINGS, (2.5, 4.5), 0))
        cases["start", name] = partial(start_s, name)
    for fish in (0, FISH):
        cases["school", f"{fish} fish" if fish else bare] = partial(school_ping_s, *among_fish(bare, fish))
    found = alternated(cases, rounds, warm_up=True)
    table = new_table(f"Cover, against {bare}: medians", "what", "scenario", "ms", "ratio", "goal", "met", texts=2)
    results: dict[str, float] = {}
    for (what, name), seconds in medians(found).items():
        results[f"{what}_{name}_s"] = seconds
        value = ratio(found[what, name], found[what, bare])
        if name != bare:
            results[f"{what}_{name}/{bare}"] = value
        goal = goal_cells(value, GOALS[what], at_most=True) if name != bare else ("", "")
        table.add_row(what, name, f"{1e3 * seconds:,.2f}", f"{value:.2f}", *goal)
    console.print(table)
    return results


def places(sim: Simulator, count: int, heights_m: tuple[float, float], pitch_deg: float) -> Places:
    """Return fixed places over the middle half of the bed, outside solids."""
    random = np.random.default_rng(54)
    x0, y0, x1, y1 = sim.world.terrain_extent_m
    found: Places = []
    while len(found) < count:
        x, y = random.uniform((0.5 * x0, 0.5 * y0), (0.5 * x1, 0.5 * y1))
        at = np.array([x, y, float(sim.world.height_at([[x, y]])[0]) + random.uniform(*heights_m)])
        turn = Rotation.from_euler("ZYX", [random.uniform(0, 360), pitch_deg, 0], degrees=True)
        if at[2] <= -0.5 and sim.world.solid_around(at) is None:
            found.append((at, turn.as_quat()))
    return found


def picture_s(sim: Simulator, places: Places) -> float:
    """Return the time of a picture, without placing the vehicle."""
    camera = sim.rov.cameras["front"].resized(SIZE, SIZE)
    return _each_s(sim, places, camera.capture)


def ping_s(sim: Simulator, places: Places) -> float:
    """Return the time of a ping, without placing the vehicle."""
    return _each_s(sim, places, sim.rov.sonar.ping)


def _each_s(sim: Simulator, places: Places, call: Callable[[], object]) -> float:
    elapsed_s = 0.0
    for position, orientation in places:
        sim.rov.place(position, orientation)
        begun = time.thread_time()
        call()
        elapsed_s += time.thread_time() - begun
    return elapsed_s / len(places)


def start_s(name: str) -> float:
    """Return the processor time that a new process spends on the scenario up to its first ping, after the imports."""
    return float(result_of(child(__file__, name)))


def started_s(name: str) -> float:
    """Return the processor time of a start in this process."""
    begun = time.process_time()
    sim = Simulator(name, threads=1)
    sim.rov.release()
    sim.rov.sonar.ping()
    return time.process_time() - begun


def among_fish(name: str, count: int) -> tuple[Simulator, NDArray[np.float64]]:
    """Return a scenario with a school that swims where the sonar looks, and the place of its vehicle (3,)."""
    scenario = load(name)
    x, y, _ = scenario.station.position_m
    with Simulator(scenario) as sim:
        bed_m = float(sim.world.height_at([[x, y]])[0])
    if count:
        school = {
            "kind": "school",
            "name": "fish",
            "count": count,
            "size_m": [0.15, 0.25],
            "position_m": [x + 6, y, bed_m + 3],
            "round_m": 4,
            "spread_m": [3, 1.5, 1],
            "seed": 0,
        }
        scenario = validated(Scenario, scenario.given() | {"life": [school]})
    sim = Simulator(scenario, threads=1)
    sim.rov.release()
    return sim, np.array([x, y, bed_m + 6])


def school_ping_s(sim: Simulator, at_m: NDArray[np.float64]) -> float:
    """Return the time of a ping, each at a new time, so that the fish have new places."""
    elapsed_s = 0.0
    for _ in range(PINGS):
        sim.step(20)
        sim.rov.place(at_m, [0, 0, 0, 1])
        begun = time.thread_time()
        sim.rov.sonar.ping()
        elapsed_s += time.thread_time() - begun
    return elapsed_s / PINGS


if __name__ == "__main__":
    print(started_s(sys.argv[1]))
