"""The cost of loose bodies at rest: 100 boxes on the bed, beside two more vehicles.

The cases alternate within one run, so that other load affects them equally. Times are CPU times of the process, on one
thread, for a step in calm water.
"""

from __future__ import annotations

import statistics
from functools import partial
from typing import Annotated, Any

import typer
from _harness import alternated, console, spent_s

from uwsim import Simulator
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

TERRAIN = {"source": "noise", "size_m": [80, 80], "spacing_m": 1, "bed_depth_m": 10, "hill_height_m": 0}
SETTLING_S = 20.0
MOST = 1.0  # of the cost of two vehicles


def main(
    rounds: Annotated[int, typer.Option(min=1, help="Rounds; medians over them are reported.")] = 15,
    steps: Annotated[int, typer.Option(min=1, help="Steps of each case in a round.")] = 2000,
    bodies: Annotated[int, typer.Option(min=1, max=200, help="Bodies at rest.")] = 100,
) -> dict[str, Any]:
    """Measure all cases alternately; print what a step costs, and the bodies' share of the cost of two vehicles."""
    worlds = {"one": world(1, 0), "three": world(3, 0), "resting": world(1, bodies)}
    times = alternated({name: partial(step_s, sim, steps) for name, sim in worlds.items()}, rounds, warm_up=True)
    one, three, resting = (times[name] for name in worlds)
    vehicles_s = statistics.median(more - alone for more, alone in zip(three, one, strict=True))
    bodies_s = statistics.median(more - alone for more, alone in zip(resting, one, strict=True))
    share = statistics.median((r - o) / (t - o) for r, t, o in zip(resting, three, one, strict=True))
    console.print(f"one vehicle {1e6 * statistics.median(one):.2f} us a step, two more {1e6 * vehicles_s:.2f} us")
    console.print(
        f"{bodies} bodies at rest {1e6 * bodies_s:.2f} us, {share:.2f} of two vehicles; "
        f"{'within' if share <= MOST else 'ABOVE'} {MOST:g}"
    )
    return {"vehicles_s": vehicles_s, "bodies_s": bodies_s, "share": share}


def world(vehicles: int, bodies: int) -> Simulator:
    """Return a world whose bodies have come to rest on a flat bed; its vehicles float in mid-water."""
    rovs = [
        {"name": f"rov_{k}", "model": "bluerov2_heavy", "start": {"position_m": [3 * k, -20, -4]}}
        for k in range(vehicles)
    ]
    boxes = [
        {
            "shape": {
                "kind": "box", "name": f"box_{k}", "size_m": [0.4, 0.4, 0.4],
                "position_m": [1.5 * (k % 10) - 7, 1.5 * (k // 10) - 7, 0], "on_bed": True,
            },
            "density_kg_m3": 2000,
        }
        for k in range(bodies)
    ]  # fmt: skip
    scenario = {"name": "bench", "terrain": TERRAIN, "vehicles": rovs, "objects": boxes}
    sim = Simulator(validated(Scenario, scenario))
    sim.advance(SETTLING_S)
    return sim


def step_s(sim: Simulator, steps: int) -> float:
    """Return the time of a step."""
    return spent_s(lambda: sim.step(steps)) / steps
