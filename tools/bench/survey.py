"""Measure where a survey spends its time: real-time factor and share of each stage, medians of runs in one process."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from _harness import alternated, console, medians, new_table

from uwsim import Simulator
from uwsim.flight.flyable_lanes import required_survey
from uwsim.flight.record import MAP_THREAD_STAGES, STAGES, WAITING, FlightRecord
from uwsim.flight.survey import fly_survey
from uwsim.mapping import ENGINES, OccupancyMap


def main(
    scenario: Annotated[str, typer.Argument(help="Name of a packaged scenario, or path of a YAML file.")] = "lake",
    runs: Annotated[int, typer.Option(min=1, help="Number of surveys; medians are reported.")] = 3,
    mission_time: Annotated[
        float | None, typer.Option(help="Simulated time of each survey [s]; 0 for the whole survey.")
    ] = 300.0,
    voxel: Annotated[float | None, typer.Option(help="Edge of a voxel [m]. Default: the scenario's.")] = None,
    engine: Annotated[str, typer.Option(help=f"Engine of the map: {', '.join(ENGINES)}.")] = "bricks",
    threads: Annotated[int | None, typer.Option(help="Number of threads. Default: one per core.")] = None,
) -> dict[str, Any]:
    """Fly a survey several times, and print medians."""

    def fly() -> FlightRecord:
        sim = Simulator(scenario, mission_time_s=mission_time or None, threads=threads)
        voxel_m = voxel if voxel is not None else required_survey(sim.scenario).voxel_m
        return fly_survey(sim, OccupancyMap(voxel_m, engine=engine))[1]

    records = alternated({"survey": fly}, runs)["survey"]
    first, stages = records[0], (*STAGES, WAITING)
    results = medians(
        {
            "real_time_factor": [r.real_time_factor for r in records],
            "simulated_s": [r.simulated_s for r in records],
            "wall_s": [r.wall_s for r in records],
            "pings": [float(r.ping_count) for r in records],
            **{f"{stage}_s": [r.stage_wall_s[stage] for r in records] for stage in stages},
            "rest_s": [r.rest_wall_s for r in records],
        }
    )
    title = (
        f"{first.scenario}, model {first.sonar_model}, {engine} at {first.voxel_m:g} m, {first.threads} threads: "
        f"{results['real_time_factor']:.1f} x real time over {results['simulated_s']:.0f} simulated s"
    )
    table = new_table(title, "stage", "wall s", "share of wall", "us per ping")
    for stage in (*stages, "rest", "wall"):
        seconds = results[f"{stage}_s"]
        name = f"{stage} (in parallel)" if stage in MAP_THREAD_STAGES and first.threads > 1 else stage
        ping_us = 1e6 * seconds / max(results["pings"], 1.0)
        table.add_row(name, f"{seconds:.2f}", f"{seconds / results['wall_s']:.0%}", f"{ping_us:.0f}")
    console.print(table)
    return results
