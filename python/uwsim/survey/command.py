"""`uwsim survey`: fly, write the map, score it, draw, report."""

from __future__ import annotations

import tempfile
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from uwsim.mapping import OccupancyMap
from uwsim.simulator import Simulator
from uwsim.survey.fly import INTERRUPTED, fly_survey, required_survey
from uwsim.survey.pictures import draw_pictures
from uwsim.survey.record import SurveyRecord
from uwsim.survey.report import write_report
from uwsim.survey.score import score_map
from uwsim.survey.table import summary_table


def run_survey(
    scenario: str | Path,
    out: Path,
    *,
    seed: int | None = None,
    sonar_model: int | None = None,
    mission_time_s: float | None = None,
    voxel_m: float | None = None,
    threads: int | None = None,
) -> bool:
    """Fly a scenario's survey and leave map.bt, report.html and pictures in `out`; true if Ctrl-C ended it early.

    Raises ScenarioError or ValueError for what is wrong in the scenario or the options, OSError for `out`.
    """
    console = Console()
    with console.status(f"building {scenario}"):
        sim = Simulator(scenario, seed=seed, sonar_model=sonar_model, mission_time_s=mission_time_s, threads=threads)
        survey = required_survey(sim.scenario)
        occupancy = OccupancyMap(resolution_m=survey.voxel_m if voxel_m is None else voxel_m)
    _require_writable(out)

    progress = Progress(
        TextColumn("surveying {task.fields[scenario]}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("[dim]{task.fields[note]}"),
        console=console,
    )
    with progress:
        task = progress.add_task("", total=1.0, scenario=sim.scenario.name, note="")
        _, record = fly_survey(
            sim,
            occupancy,
            on_progress=lambda share: progress.update(
                task, completed=share, note=f"{sim.time_s / 60:.1f} min simulated"
            ),
        )
    occupancy.write(out / "map.bt")  # before anything else can fail
    if record.stopped_because == INTERRUPTED:
        console.print("interrupted: the map of what was seen so far is kept; reporting on it")
    with console.status("scoring the map and drawing the report"):
        _report(sim, occupancy, record, out, console)
    return record.stopped_because == INTERRUPTED


def _report(sim: Simulator, occupancy: OccupancyMap, record: SurveyRecord, out: Path, console: Console) -> None:
    occupied = occupancy.occupied_voxels()
    free_voxels = occupancy.statistics().free_voxels
    score = score_map(
        sim.world, occupied, occupancy.resolution_m, record.path_world_m, record.area_world_m, record.range_max_m
    )
    pictures = draw_pictures(out, sim.world, record, score, occupied)
    write_report(out / "report.html", record, score, free_voxels, pictures)
    console.print(summary_table(record, score, free_voxels))
    console.print(f"ended because {record.stopped_because}")
    console.print(f"{out / 'map.bt'}  {out / 'report.html'}", highlight=False)


def _require_writable(folder: Path) -> None:
    """Before an hour is flown for nothing. Raises OSError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(f"--out {folder}: cannot write there: {error.strerror}") from error
