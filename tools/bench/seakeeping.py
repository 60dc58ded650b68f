"""The cost of the waves that a floating hull makes and deflects, beside the same hull without a table.

All cases alternate within one run, so that other load affects them equally. Times are CPU times of the process, on one
thread, for a simulated second: a barge of 2 m in still water and in a sea of 64 waves.
"""

from __future__ import annotations

import json
import statistics
import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import trimesh
import typer
from _harness import alternated, console, ratio, spent_s

from uwsim import Simulator
from uwsim.evidence.validate.peers.floating_hulls import table_file

MOST = 1.5
SEA = {"kind": "jonswap", "significant_height_m": 0.1, "peak_period_s": 2.2}  # 64 waves
BARGE: dict[str, Any] = {
    "name": "barge", "mesh": "barge.obj", "mass_kg": 480.0, "centre_of_mass_m": [0.0, 0.0, 0.05],
    "added_mass": [30, 120, 250, 10, 50, 30], "linear_damping": [5] * 6, "quadratic_damping": [20] * 6,
    "max_force_n": [200, 200, 200], "max_torque_nm": [50, 50, 50],
}  # fmt: skip


def main(
    rounds: Annotated[int, typer.Option(min=1, help="Rounds; medians over them are reported.")] = 7,
    seconds: Annotated[float, typer.Option(min=0.1, help="Simulated seconds of each case in a round.")] = 10.0,
) -> dict[str, Any]:
    """Measure all cases alternately and print real-time factors, and ratios to the hull without a table."""
    with tempfile.TemporaryDirectory() as folder:
        cases = {
            (water, with_table): barge(Path(folder), surface, with_table)
            for water, surface in (("still water", {"kind": "still"}), ("in a sea", SEA))
            for with_table in (False, True)
        }
        times = alternated({case: partial(second_s, sim, seconds) for case, sim in cases.items()}, rounds, warm_up=True)
    results: dict[str, Any] = {}
    for water in ("still water", "in a sea"):
        factor = 1.0 / statistics.median(times[water, True])
        of_none = ratio(times[water, True], times[water, False])
        results[water] = {"real_time_factor": factor, "of_no_table": of_none}
        line = f"{water:12s} {factor:8.1f} times real time, {of_none:.2f} of no table"
        if water == "in a sea":
            line += f"; {'within' if of_none <= MOST else 'ABOVE'} {MOST:g}"
        console.print(line)
    return results


def barge(folder: Path, surface: dict[str, Any], with_table: bool) -> Simulator:
    """Return a simulation of a floating barge."""
    trimesh.creation.box((2.0, 0.8, 0.5)).export(folder / "barge.obj")
    model = {**BARGE, **({"radiation": str(table_file("barge"))} if with_table else {})}
    (folder / "barge.yaml").write_text(json.dumps(model))
    scenario = {
        "name": "bench", "water": {"density_kg_m3": 1000, "surface": surface},
        "terrain": {"source": "noise", "size_m": [200, 200], "spacing_m": 2, "bed_depth_m": 60},
        "vehicles": [{"name": "rov", "model": str(folder / "barge.yaml"), "start": {"position_m": [0, 0, -0.05]}}],
    }  # fmt: skip
    (folder / "bench.yaml").write_text(json.dumps(scenario))
    return Simulator(folder / "bench.yaml")


def second_s(sim: Simulator, seconds: float) -> float:
    """Return the time that a simulated second takes."""
    return spent_s(lambda: sim.advance(seconds)) / seconds
