"""The cost of an arm: a vehicle with four joints that move, and with the arm at rest, beside the vehicle alone.

The cases alternate within one run, so that other load affects them equally. Times are CPU times of the process, on one
thread, for a step in calm, open water.
"""

from __future__ import annotations

import statistics
from functools import partial
from typing import Annotated, Any

import typer
from _harness import alternated, console, ratio, spent_s

from uwsim import Simulator
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

LEAST_SHARE = 0.25  # of the steps a second of the vehicle alone
TERRAIN = {"source": "noise", "size_m": [60, 60], "spacing_m": 1, "bed_depth_m": 15, "hill_height_m": 0}
JOINTS = ("shoulder", "upperarm", "forearm", "wrist")


def main(
    rounds: Annotated[int, typer.Option(min=1, help="Rounds; medians over them are reported.")] = 9,
    steps: Annotated[int, typer.Option(min=1, help="Steps of each case in a round.")] = 4000,
) -> dict[str, Any]:
    """Measure all cases alternately and print the time of a step, and the share of the plain vehicle's steps."""
    cases = {
        "no arm": partial(step_s, "bluerov2_heavy", steps),
        "at rest": partial(step_s, "bluerov2_heavy_alpha5", steps),
        "moving": partial(step_s, "bluerov2_heavy_alpha5", steps, speed=0.1),
    }
    times = alternated(cases, rounds, warm_up=True)
    results: dict[str, Any] = {}
    for name, spent in times.items():
        share = ratio(times["no arm"], spent)
        results[name] = {"step_s": statistics.median(spent), "share_of_no_arm": share}
        line = f"{name:8s} {1e6 * results[name]['step_s']:7.2f} us a step, {share:5.2f} of the steps of no arm"
        if name != "no arm":
            line += f"; {'within' if share >= LEAST_SHARE else 'BELOW'} {LEAST_SHARE:g}"
        console.print(line)
    return results


def step_s(model: str, steps: int, speed: float = 0.0) -> float:
    """Return the time of a step of a new vehicle of this model, whose joints turn at `speed` [rad/s]."""
    rov = {"name": "rov", "model": model, "start": {"position_m": [0, 0, -5]}}
    sim = Simulator(validated(Scenario, {"name": "bench", "terrain": TERRAIN, "vehicles": [rov]}))
    if speed:
        sim.rov.set_joints(speeds=dict.fromkeys(JOINTS, speed))
    return spent_s(lambda: sim.step(steps)) / steps
