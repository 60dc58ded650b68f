"""The cost of loose bodies at rest: 100 boxes on the bed, beside two more vehicles.

Times are CPU times of the process, on one thread, for a step in calm water.
"""

from __future__ import annotations

import statistics
from typing import Annotated, Any

import typer
from _harness import Rounds, alternated, flat_water, show, spent_s

from uwsim import Simulator


def main(
    rounds: Rounds = 15,
    steps: Annotated[int, typer.Option(min=1, help="Steps of each case in a round.")] = 2000,
    bodies: Annotated[int, typer.Option(min=1, max=200, help="Bodies at rest.")] = 100,
) -> dict[str, Any]:
    """Measure all cases alternately; print what a step costs, and the bodies' share of the cost of two vehicles."""
    worlds = {"one": world(1, 0), "three": world(3, 0), "resting": world(1, bodies)}
    cases = {name: lambda sim=sim: spent_s(lambda: sim.step(steps)) / steps for name, sim in worlds.items()}
    times = alternated(cases, rounds, warm_up=True)
    rows = list(zip(*(times[name] for name in worlds), strict=True))
    results = {
        "one vehicle [us]": 1e6 * statistics.median(one for one, _, _ in rows),
        "two more [us]": 1e6 * statistics.median(three - one for one, three, _ in rows),
        "bodies at rest [us]": 1e6 * statistics.median(resting - one for one, _, resting in rows),
        "bodies of two vehicles": statistics.median((resting - one) / (three - one) for one, three, resting in rows),
    }
    show(f"a step with {bodies} bodies", results, {"bodies of two vehicles": "<= 1"})
    return results


def world(vehicles: int, bodies: int) -> Simulator:
    """Return a world whose bodies have come to rest on a flat bed; its vehicles float in mid-water."""
    rovs = [{"model": "bluerov2_heavy", "start": {"position_m": [3 * k, -20, -4]}} for k in range(vehicles)]
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
    sim = flat_water(rovs, 10.0, objects=boxes)
    sim.advance(20.0)
    return sim
