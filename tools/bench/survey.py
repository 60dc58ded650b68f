"""Measure where a survey spends its time: real-time factor and share of each stage, medians of runs in one process.

With several engines the runs alternate, so that a busy machine slows all of them equally.
"""

from __future__ import annotations

import json
import statistics
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from uwsim import Simulator
from uwsim.flight.flyable_lanes import required_survey
from uwsim.flight.record import FlightRecord
from uwsim.flight.stages import MAP_THREAD_STAGES, STAGES, WAITING
from uwsim.flight.survey import fly_survey
from uwsim.mapping import ENGINES, OccupancyMap

console = Console()


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
    json_file: Annotated[Path | None, typer.Option("--json", help="A JSON file to write the results to.")] = None,
) -> None:
    """Fly a survey several times, and print medians."""
    engines = engine or ["bricks"]
    records: dict[str, list[FlightRecord]] = {name: [] for name in engines}
    for run in range(runs):
        for name in engines:
            with console.status(f"run {run + 1} of {runs}, {name}"):
                sim = Simulator(scenario, mission_time_s=mission_time or None, threads=threads)
                voxel_m = voxel if voxel is not None else required_survey(sim.scenario).voxel_m
                records[name].append(fly_survey(sim, OccupancyMap(voxel_m, engine=name))[1])
    figures = {name: summarise(flown) for name, flown in records.items()}
    for name, flown in records.items():
        console.print(_table(name, figures[name], flown[0]))
    if len(engines) > 1:
        first, second = (figures[name]["real_time_factor"] for name in engines[:2])
        console.print(f"{engines[0]} / {engines[1]}: {first / second:.2f} times the real-time factor")
    if json_file is not None:
        written = figures if len(engines) > 1 else figures[engines[0]]
        json_file.write_text(json.dumps(written, indent=2) + "\n", encoding="utf-8")


def summarise(records: list[FlightRecord]) -> dict[str, float]:
    """Return medians over the runs: real-time factor, wall time, and each stage's wall seconds."""

    def median(values: list[float]) -> float:
        return statistics.median(values)

    figures = {
        "real_time_factor": median([r.real_time_factor for r in records]),
        "simulated_s": median([r.simulated_s for r in records]),
        "wall_s": median([r.wall_s for r in records]),
        "pings": median([float(r.ping_count) for r in records]),
    }
    for stage in (*STAGES, WAITING):
        figures[f"{stage}_s"] = median([r.stage_wall_s[stage] for r in records])
    figures["rest_s"] = median([r.rest_wall_s for r in records])
    return figures


def _table(engine: str, figures: dict[str, float], record: FlightRecord) -> Table:
    table = Table(
        title=f"{record.scenario}, model {record.sonar_model}, {engine} at {record.voxel_m:g} m, "
        f"{record.threads} threads: {figures['real_time_factor']:.1f} x real time over "
        f"{figures['simulated_s']:.0f} simulated s",
        title_justify="left",
    )
    table.add_column("stage")
    for column in ("wall s", "share of wall", "us per ping"):
        table.add_column(column, justify="right")
    for stage in (*STAGES, WAITING, "rest"):
        seconds = figures[f"{stage}_s"]
        name = f"{stage} (in parallel)" if stage in MAP_THREAD_STAGES and record.threads > 1 else stage
        share, ping_us = seconds / figures["wall_s"], 1e6 * seconds / max(figures["pings"], 1.0)
        table.add_row(name, f"{seconds:.2f}", f"{share:.0%}", f"{ping_us:.0f}")
    table.add_row(
        "wall", f"{figures['wall_s']:.2f}", "100%", f"{1e6 * figures['wall_s'] / max(figures['pings'], 1.0):.0f}"
    )
    return table


if __name__ == "__main__":
    app = typer.Typer(add_completion=False)
    app.command()(main)
    app(prog_name="uwsim bench survey")
