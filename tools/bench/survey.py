"""Measure where a survey spends its time: real-time factor and share of each stage, medians of runs in one process.

With several engines the runs alternate, so that a busy machine slows all of them equally.
"""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

import typer
from _harness import alternated, console, medians, new_table
from rich.table import Table

from uwsim import Simulator
from uwsim.flight.flyable_lanes import required_survey
from uwsim.flight.record import FlightRecord
from uwsim.flight.stages import MAP_THREAD_STAGES, STAGES, WAITING
from uwsim.flight.survey import fly_survey
from uwsim.mapping import ENGINES, OccupancyMap


def main(
    scenario: Annotated[str, typer.Argument(help="Name of a packaged scenario, or path of a YAML file.")] = "lake",
    runs: Annotated[int, typer.Option(min=1, help="Number of surveys with each engine; medians are reported.")] = 3,
    mission_time: Annotated[
        float | None, typer.Option(help="Simulated time of each survey [s]; 0 for the whole survey.")
    ] = 300.0,
    voxel: Annotated[float | None, typer.Option(help="Edge of a voxel [m]. Default: the scenario's.")] = None,
    engine: Annotated[
        list[str] | None,
        typer.Option(help=f"Engine of the map: {', '.join(ENGINES)}; may be repeated. Default: bricks."),
    ] = None,
    threads: Annotated[int | None, typer.Option(help="Number of threads. Default: one per core.")] = None,
) -> dict[str, Any]:
    """Fly a survey several times, and print medians."""
    engines = engine or ["bricks"]

    def fly(name: str) -> FlightRecord:
        sim = Simulator(scenario, mission_time_s=mission_time or None, threads=threads)
        voxel_m = voxel if voxel is not None else required_survey(sim.scenario).voxel_m
        return fly_survey(sim, OccupancyMap(voxel_m, engine=name))[1]

    records = alternated({name: partial(fly, name) for name in engines}, runs)
    results = {name: summarise(flown) for name, flown in records.items()}
    for name, flown in records.items():
        console.print(_table(name, results[name], flown[0]))
    if len(engines) > 1:
        first, second = (results[name]["real_time_factor"] for name in engines[:2])
        console.print(f"{engines[0]} / {engines[1]}: {first / second:.2f} times the real-time factor")
    return results if len(engines) > 1 else results[engines[0]]


def summarise(records: list[FlightRecord]) -> dict[str, float]:
    """Return medians over the runs: real-time factor, wall time, and each stage's wall seconds."""
    found = {
        "real_time_factor": [r.real_time_factor for r in records],
        "simulated_s": [r.simulated_s for r in records],
        "wall_s": [r.wall_s for r in records],
        "pings": [float(r.ping_count) for r in records],
        **{f"{stage}_s": [r.stage_wall_s[stage] for r in records] for stage in (*STAGES, WAITING)},
        "rest_s": [r.rest_wall_s for r in records],
    }
    return medians(found)


def _table(engine: str, results: dict[str, float], record: FlightRecord) -> Table:
    title = (
        f"{record.scenario}, model {record.sonar_model}, {engine} at {record.voxel_m:g} m, {record.threads} threads: "
        f"{results['real_time_factor']:.1f} x real time over {results['simulated_s']:.0f} simulated s"
    )
    table = new_table(title, "stage", "wall s", "share of wall", "us per ping")
    for stage in (*STAGES, WAITING, "rest"):
        seconds = results[f"{stage}_s"]
        name = f"{stage} (in parallel)" if stage in MAP_THREAD_STAGES and record.threads > 1 else stage
        share, ping_us = seconds / results["wall_s"], 1e6 * seconds / max(results["pings"], 1.0)
        table.add_row(name, f"{seconds:.2f}", f"{share:.0%}", f"{ping_us:.0f}")
    table.add_row(
        "wall", f"{results['wall_s']:.2f}", "100%", f"{1e6 * results['wall_s'] / max(results['pings'], 1.0):.0f}"
    )
    return table
