"""The cost of a tether of 100 elements: still, in a sea, on the bed and round a pile, beside the vehicle alone.

Times are CPU times of the process, on one thread, for a simulated second.
"""

from __future__ import annotations

import itertools
from functools import partial
from typing import Annotated, Any

import typer
from _harness import Rounds, beside, flat_water, show, spent_s

SEA = {"kind": "jonswap", "significant_height_m": 0.5, "peak_period_s": 4.0}  # 64 waves
PILE = {"kind": "cylinder", "name": "pile", "position_m": [0, 1, -10], "radius_m": 0.3, "length_m": 24}
TETHER = {"anchor": [-15, 0, -2], "length_m": 50.0, "elements": 100}
CASES: dict[str, tuple[dict[str, Any] | None, dict[str, Any]]] = {
    "no tether": (None, {}),
    "still water": (TETHER, {}),
    "in a sea": (TETHER, {"water": {"surface": SEA}}),
    "on the bed": ({**TETHER, "mass_kg_m": 0.1}, {}),
    "round a pile": (TETHER, {"obstacles": [PILE]}),
}


def main(
    rounds: Rounds = 7,
    seconds: Annotated[float, typer.Option(min=0.1, help="Simulated seconds of each case in a round.")] = 2.0,
) -> dict[str, Any]:
    """Measure all cases alternately and print times, real-time factors and ratios to the vehicle alone."""
    cases = {name: partial(second_s, Run(*each), seconds) for name, each in CASES.items()}
    results = beside("a simulated second", cases, rounds, "no tether")
    factors = {name: 1.0 / each["s"] for name, each in results.items()}
    show("times real time", factors, dict.fromkeys(CASES, ">= 100"))
    return {name: each | {"real_time_factor": factors[name]} for name, each in results.items()}


class Run:
    """A vehicle that flies to and fro."""

    def __init__(self, tether: dict[str, Any] | None, others: dict[str, Any]) -> None:
        rov = {"model": "bluerov2_heavy", "start": {"position_m": [15, 0, -8]}}
        self.sim = flat_water([rov | ({"tether": tether} if tether else {})], **others)
        self.surge = itertools.cycle((0.3, -0.3))


def second_s(run: Run, seconds: float) -> float:
    """Return the time that a simulated second takes."""
    run.sim.rov.set_effort(surge=next(run.surge), sway=0.2)
    return spent_s(lambda: run.sim.advance(seconds)) / seconds
