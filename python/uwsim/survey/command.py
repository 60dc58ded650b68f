"""`uwsim survey`: fly, write the map, score it, draw, report."""

from __future__ import annotations

import math
import os
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.scenario import Scenario, Survey, load
from uwsim.scenario.messages import validated
from uwsim.simulator import Simulator
from uwsim.survey.autosave import Autosave
from uwsim.survey.checkpoint import MAP, Checkpoint, SavedSurvey, SurveyOrder
from uwsim.survey.fly import fly_survey, required_survey
from uwsim.survey.pictures import PICTURES, draw_pictures
from uwsim.survey.record import SurveyRecord
from uwsim.survey.report import write_report
from uwsim.survey.score import score_map
from uwsim.survey.table import summary_table
from uwsim.survey.track import TRACK, Track

REPORT = "report.html"
AUTOSAVE_S = 30.0


def run_survey(
    scenario: str | Path,
    out: Path,
    *,
    seed: int | None = None,
    sonar_model: int | str | None = None,
    sonar_frequency_khz: float | None = None,
    mission_time_s: float | None = None,
    voxel_m: float | None = None,
    threads: int | None = None,
    engine: MapEngine | None = None,
    verify_map: bool = False,
    autosave_s: float = AUTOSAVE_S,
    map_memory_mb: float | None = None,
) -> SurveyRecord:
    """Fly a scenario's survey and leave map.bt, report.html and pictures in `out`; returns the survey's record.

    sonar_frequency_khz: of a sonar that works at several. engine: of the map, bricks by default. verify_map: insert
    every scan into a stock OctoMap map too, and compare. autosave_s: wall time between saves, from which
    `resume_survey` flies on; 0 for none. map_memory_mb: what the map may take of memory, the rest of it on disk; the
    bytes of map.bt do not depend on it.
    Raises ScenarioError or ValueError for what is wrong in the scenario or the options, OSError for `out`. Whatever
    ends the flight, the map of what was seen until then is written.
    """
    _require_interval(autosave_s)
    progress = Console(stderr=True)
    with progress.status(f"building {scenario}"):
        _require_surveyable(load(scenario))  # before the world is built
        sim = Simulator(
            scenario,
            seed=seed,
            sonar_model=sonar_model,
            sonar_frequency_khz=sonar_frequency_khz,
            mission_time_s=mission_time_s,
            threads=threads,
        )
        survey = required_survey(sim.scenario)
        if voxel_m is not None:
            survey = validated(Survey, {**dict(survey), "voxel_m": voxel_m})
        order = SurveyOrder(
            scenario=_source(scenario),
            seed=sim.seed,
            sonar_model=_source(sonar_model) if isinstance(sonar_model, str) else sonar_model,
            sonar_frequency_khz=sonar_frequency_khz,
            mission_time_s=mission_time_s,
            voxel_m=survey.voxel_m,
            engine=engine or "bricks",
            verify_map=verify_map,
        )
        occupancy, reference = order.new_map(map_memory_mb), order.new_reference()
    _require_writable(out)
    checkpoint = Checkpoint(out)
    checkpoint.sweep()
    if (earlier := checkpoint.set_aside()) is not None:
        progress.print(f"an unfinished survey was in {out}; it is kept in {earlier}", highlight=False)
    return _Survey(sim, occupancy, reference, order, checkpoint, autosave_s, progress).fly_and_report()


def resume_survey(
    out: Path,
    *,
    threads: int | None = None,
    autosave_s: float = AUTOSAVE_S,
    map_memory_mb: float | None = None,
    **asked: Any,
) -> SurveyRecord:
    """Fly on what `run_survey` last saved in `out`, to the same map as if nothing had happened.

    asked: the rest of run_survey's arguments; those that are not None must be what they were then.
    Raises ValueError when nothing can be resumed there, or not with these; else as run_survey.
    """
    _require_interval(autosave_s)
    progress = Console(stderr=True)
    checkpoint = Checkpoint(out)
    with progress.status(f"resuming {out}"):
        saved = checkpoint.read(map_memory_mb)
        _require_same(saved.order, asked)
        order = saved.order
        sim = Simulator(
            order.scenario,
            seed=order.seed,
            sonar_model=order.sonar_model,
            sonar_frequency_khz=order.sonar_frequency_khz,
            mission_time_s=order.mission_time_s,
            threads=threads,
        )
    _require_writable(out)
    checkpoint.sweep()
    survey = _Survey(sim, saved.occupancy, saved.reference, order, checkpoint, autosave_s, progress)
    return survey.fly_and_report(saved)


def _require_surveyable(scenario: Scenario) -> None:
    required_survey(scenario)
    first = scenario.vehicles[0]
    if first.model.sonar is None:
        raise ValueError(f"vehicle '{first.name}': carries no sonar to survey with")


def _require_interval(autosave_s: float) -> None:
    if not (math.isfinite(autosave_s) and autosave_s >= 0.0):
        raise ValueError(f"autosave_s = {autosave_s} s: must be 0 (never) or more")


def _require_same(order: SurveyOrder, asked: dict[str, Any]) -> None:
    """Raises ValueError when a survey is to be resumed as another."""
    if asked.get("scenario") is not None:
        asked["scenario"] = _source(asked["scenario"])
    if isinstance(asked.get("sonar_model"), str):
        asked["sonar_model"] = _source(asked["sonar_model"])
    for name, value in asked.items():
        was = getattr(order, name)
        if value is not None and value != was:
            raise ValueError(f"--resume: {name} = {value}: the survey was begun with {was}")


def _source(scenario: str | Path) -> str:
    """A packaged one's name, or its file wherever one is."""
    return str(Path(scenario).resolve()) if Path(scenario).is_file() else str(scenario)


@dataclass
class _Survey:
    """A survey about to be flown."""

    sim: Simulator
    occupancy: OccupancyMap
    reference: OccupancyMap | None
    order: SurveyOrder
    checkpoint: Checkpoint
    autosave_s: float
    progress: Console

    def fly_and_report(self, saved: SavedSurvey | None = None) -> SurveyRecord:
        out, progress = self.checkpoint.out, self.progress
        watch = Autosave(self.checkpoint, self.order, self.autosave_s, lambda text: _tell(progress, text))
        for stale in (TRACK, REPORT, *PICTURES):  # of an earlier flight: they tell of another map
            (out / stale).unlink(missing_ok=True)
        try:
            record = self._fly(watch, saved)
        except BaseException as error:
            try:
                self._write_map()
            except OSError as second:
                raise OSError(f"{error}; and {second}") from error
            raise
        self._write_map()
        if record.interrupted:
            resumable = self.checkpoint.exists and watch.failure is None
            hint = "; uwsim survey --resume flies on" if resumable else ""
            seen = f"{out / MAP} holds what was seen so far"
            _tell(progress, f"interrupted; {seen}{hint} (Ctrl-C again skips the report)")
        if self.reference is not None:
            record = replace(record, verified=_same_map(self.occupancy, self.reference))
        try:
            _report(self.sim, self.occupancy, record, out, progress)
        except OSError as error:
            again = "; uwsim survey --resume makes the report" if self.checkpoint.exists else ""
            raise OSError(f"{error} ({out / MAP} is complete{again})") from error
        if not record.interrupted:
            self.checkpoint.remove()  # not before: what ends the report alone is made good by --resume
        if record.verified is not None:
            _print(f"{MAP} {'is identical to' if record.verified else 'DIFFERS from'} that of stock OctoMap")
        return record

    def _fly(self, watch: Autosave, saved: SavedSurvey | None) -> SurveyRecord:
        bar = Progress(
            TextColumn("surveying {task.fields[scenario]}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("[dim]{task.fields[note]}"),
            console=self.progress,
            disable=not self.progress.is_terminal,
        )
        sim = self.sim
        with bar, _ctrl_c_stops(watch):
            task = bar.add_task("", total=1.0, scenario=sim.scenario.name, note="")

            def show(share: float) -> None:
                bar.update(task, completed=share, note=f"{sim.time_s / 60:.1f} min simulated")

            return fly_survey(
                sim,
                self.occupancy,
                on_progress=show,
                reference=self.reference,
                watch=watch,
                resume=saved.state if saved is not None else None,
            )[1]

    def _write_map(self) -> None:
        """Where it belongs, else somewhere: hours may be in it. Raises OSError that says what was tried."""
        path = self.checkpoint.out / MAP
        try:
            self.occupancy.write(path)
        except OSError as error:
            tried = str(error)
            if self.checkpoint.exists:
                tried += "; free some space, and uwsim survey --resume flies on from the last save"
            try:
                elsewhere = Path(tempfile.mkdtemp(prefix="uwsim-")) / MAP
                self.occupancy.write(elsewhere)
            except OSError as second:
                raise OSError(f"{tried}; nor elsewhere: {second}") from error
            raise OSError(f"{tried}; the map is in {elsewhere}") from error


def _same_map(one: OccupancyMap, other: OccupancyMap) -> bool:
    return one.to_bytes("ot") == other.to_bytes("ot") and one.to_bytes("bt") == other.to_bytes("bt")


def _tell(console: Console, text: str) -> None:
    console.print(text, highlight=False, markup=False, soft_wrap=True)


@contextmanager
def _ctrl_c_stops(watch: Autosave) -> Iterator[None]:
    """While the vehicle flies, Ctrl-C and SIGTERM end the mission, not the program: gently, and at once if repeated."""

    def stop(number: int, frame: object) -> None:
        if watch.stopping():
            raise KeyboardInterrupt
        watch.stop()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
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
    with progress.status("drawing the report"):
        Track.of(record).write(out / TRACK)
        pictures = draw_pictures(out, sim.world, record, score, occupied)
        write_report(out / REPORT, record, score, free_voxels, pictures)
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
    for name in (MAP, REPORT, TRACK):
        if (folder / name).exists() and not (folder / name).is_file():
            raise OSError(f"--out {folder}: '{name}' in it is not a file")
