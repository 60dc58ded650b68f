"""`uwsim survey`: fly, write the map, score it, draw, report."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from uwsim.mapping import OccupancyMap
from uwsim.scenario import Scenario, Survey, load
from uwsim.scenario.messages import validated
from uwsim.simulator import Simulator
from uwsim.survey.fly import fly_survey, required_survey
from uwsim.survey.pictures import draw_pictures
from uwsim.survey.record import SurveyRecord
from uwsim.survey.report import write_report
from uwsim.survey.score import score_map
from uwsim.survey.table import summary_table

MAP, REPORT = "map.bt", "report.html"


def run_survey(
    scenario: str | Path,
    out: Path,
    *,
    seed: int | None = None,
    sonar_model: int | None = None,
    mission_time_s: float | None = None,
    voxel_m: float | None = None,
    threads: int | None = None,
) -> SurveyRecord:
    """Fly a scenario's survey and leave map.bt, report.html and pictures in `out`; returns the survey's record.

    Raises ScenarioError or ValueError for what is wrong in the scenario or the options, OSError for `out`. Whatever
    ends the flight, the map of what was seen until then is written.
    """
    progress = Console(stderr=True)
    with progress.status(f"building {scenario}"):
        _require_surveyable(load(scenario))  # before the world is built
        sim = Simulator(scenario, seed=seed, sonar_model=sonar_model, mission_time_s=mission_time_s, threads=threads)
        survey = required_survey(sim.scenario)
        if voxel_m is not None:
            survey = validated(Survey, {**dict(survey), "voxel_m": voxel_m})
        occupancy = OccupancyMap(resolution_m=survey.voxel_m)
    _require_writable(out)
    try:
        record = _fly(sim, occupancy, progress)
    finally:
        occupancy.write(out / MAP)
    if record.interrupted:
        progress.print(f"interrupted; {out / MAP} holds what was seen so far (Ctrl-C again skips the report)")
    _report(sim, occupancy, record, out, progress)
    return record


def _require_surveyable(scenario: Scenario) -> None:
    required_survey(scenario)
    first = scenario.vehicles[0]
    if first.model.sonar is None:
        raise ValueError(f"vehicle '{first.name}': carries no sonar to survey with")


def _fly(sim: Simulator, occupancy: OccupancyMap, console: Console) -> SurveyRecord:
    bar = Progress(
        TextColumn("surveying {task.fields[scenario]}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("[dim]{task.fields[note]}"),
        console=console,
        disable=not console.is_terminal,
    )
    with bar, _ctrl_c_interrupts():
        task = bar.add_task("", total=1.0, scenario=sim.scenario.name, note="")

        def show(share: float) -> None:
            bar.update(task, completed=share, note=f"{sim.time_s / 60:.1f} min simulated")

        return fly_survey(sim, occupancy, on_progress=show)[1]


@contextmanager
def _ctrl_c_interrupts() -> Iterator[None]:
    """While the vehicle flies, Ctrl-C and SIGTERM are a KeyboardInterrupt that ends the mission, not the program."""
    before = {number: signal.signal(number, signal.default_int_handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _report(sim: Simulator, occupancy: OccupancyMap, record: SurveyRecord, out: Path, progress: Console) -> None:
    """The table comes first, so that a full disk cannot keep it from being seen."""
    with progress.status("scoring the map"):
        occupied = occupancy.occupied_voxels()
        free_voxels = occupancy.statistics().free_voxels
        score = score_map(
            sim.world, occupied, occupancy.resolution_m, record.path_world_m, record.area_world_m, record.range_max_m
        )
    _print(summary_table(record, score, free_voxels))
    _print(f"ended because {record.stopped_because}")
    try:
        with progress.status("drawing the report"):
            pictures = draw_pictures(out, sim.world, record, score, occupied)
            write_report(out / REPORT, record, score, free_voxels, pictures)
    except OSError as error:
        raise OSError(f"{error} ({out / MAP} is complete)") from error
    _print(f"{out / MAP}  {out / REPORT}")


class _Output(Console):
    """Goes quiet when nobody reads any more: `uwsim survey | head` must not cost the report."""

    def on_broken_pipe(self) -> None:
        """Instead of ending the program, as rich would."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())


def _print(what: object) -> None:
    _Output().print(what, highlight=False)


def _require_writable(folder: Path) -> None:
    """Before an hour is flown for nothing. Raises OSError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(f"--out {folder}: cannot write there: {error.strerror}") from error
    for name in (MAP, REPORT):
        if (folder / name).exists() and not (folder / name).is_file():
            raise OSError(f"--out {folder}: '{name}' in it is not a file")
