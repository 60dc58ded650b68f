"""run_survey and resume_survey: fly a survey with autosave, write its map, and report. The job of `uwsim survey`."""

from __future__ import annotations

import math
import tempfile
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from uwsim.folder_lock import alone_in, require_free
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.scenario import Scenario, Survey, load
from uwsim.scenario.read.validated import validated
from uwsim.scoring.surface_ahead import SurfaceAhead
from uwsim.scoring.survey_track import TRACK
from uwsim.simulator import Simulator
from uwsim.stoppable import stop_on_signals
from uwsim.survey.autosave import Autosave
from uwsim.survey.checkpoint import MAP, Checkpoint, SavedSurvey
from uwsim.survey.fly import filters_outliers, fly_survey, required_survey, survey_plan
from uwsim.survey.flyable_lanes import flyable_plan
from uwsim.survey.own_mission import OwnMission, maker, name_of
from uwsim.survey.pinging_clock import TakePing
from uwsim.survey.record import ESTIMATES, INTERRUPTED, EstimateKind, SurveyRecord
from uwsim.survey.request import SurveyRequest, resolved_path
from uwsim.survey.results import (
    MAP_ASHORE,
    REPORT,
    REPORTS,
    RESULT_FILES,
    SUMMARY,
    Report,
    Scoring,
    render_ahead,
    write_results,
)
from uwsim.survey.terminal import Terminal

if TYPE_CHECKING:
    from concurrent.futures import Future

    from uwsim.closure import PingTrack
    from uwsim.figures.truth_and_map import TruthAndMap
    from uwsim.recording.recorder import Recorder

AUTOSAVE_S = 30.0


def run_survey(
    scenario: str | Path = "lake",
    out: str | Path = "out",
    *,
    mission: OwnMission | str | None = None,
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
    report: str = "full",
    outlier_filter: bool | None = None,
    record: Path | None = None,
    record_topics: tuple[str, ...] | None = None,
    estimate: EstimateKind = "truth",
    link: str | Path | None = None,
    close_loops: bool = False,
) -> SurveyRecord:
    """Fly a scenario's survey and write map.bt, report.html, summary.json and figures into `out`; returns its record.

        record = uwsim.run_survey("pool", "out/", report="json")
        print(record.coverage, record.simulated_s)

    mission: instead of the adaptive lawn-mower, a class of (vehicle, clock, plan), see uwsim.missions.Mission, a
    function `def mission(vehicle): yield ...`, or `package.module:name` of either. sonar_frequency_khz: for a sonar
    with several frequencies. engine: of the map, "bricks" by default. verify_map: insert every scan into a stock
    OctoMap map too, and compare the bytes. autosave_s: wall time between saves, from which `resume_survey` continues; 0
    for none. map_memory_mb: limit of the map's memory, the rest goes to disk; the bytes of map.bt do not depend on it.
    report: "full"; "json" for map.bt and summary.json without report and figures; "none" for map.bt alone, without a
    score. outlier_filter: replaces the scenario's. estimate: "filter" flies and maps by the vehicle's own instruments
    (Vehicle.estimate) instead of the truth. link: a modem, by name or file, instead of the scenario's; the map that the
    station makes of the pings that arrive is scored beside that aboard, and written as map_ashore.bt. close_loops: bend
    the estimated track until its submaps fit each other, and make the map from that; such a survey is not saved as it
    flies, and needs estimate="filter". record: a new recording, from which `uwsim map from` makes map and report again;
    record_topics: see Recorder. Raises ScenarioError or ValueError for an error in the scenario or the arguments,
    OSError for `out`. However the flight ends, the map of everything seen until then is written.
    """
    _require_interval(autosave_s)
    kind = _checked_report(report)
    out = Path(out)
    maker(mission)  # refuses what is none before the world is built
    if estimate not in ESTIMATES:
        raise ValueError(f"estimate = {estimate!r}: must be one of {', '.join(ESTIMATES)}")
    if estimate != "truth" and record is not None:
        raise ValueError(f"record: a survey with estimate = {estimate!r} cannot be recorded, only one with the truth")
    if close_loops and estimate != "filter":
        raise ValueError("close_loops: needs estimate = 'filter'; a track that is the truth has nothing to close")
    if close_loops and (verify_map or map_memory_mb is not None):
        raise ValueError("close_loops: cannot be combined with verify_map or map_memory_mb")
    autosave_s = 0.0 if close_loops else autosave_s
    require_free(out)
    terminal = Terminal()
    with terminal.status(f"building {scenario}"):
        loaded = load(scenario)
        _require_surveyable(loaded)  # before the world is built
        sim = Simulator(
            loaded,
            seed=seed,
            sonar_model=sonar_model,
            sonar_frequency_khz=sonar_frequency_khz,
            mission_time_s=mission_time_s,
            link=link,
            threads=threads,
        )
        survey = required_survey(sim.scenario)
        flyable_plan(sim, survey_plan(survey))  # refuses an area before anything is written
        if voxel_m is not None:
            survey = validated(Survey, {**dict(survey), "voxel_m": voxel_m})
        request = SurveyRequest(
            scenario=resolved_path(scenario),
            seed=sim.seed,
            sonar_model=resolved_path(sonar_model),
            sonar_frequency_khz=sonar_frequency_khz,
            mission_time_s=mission_time_s,
            voxel_m=survey.voxel_m,
            engine=engine or "bricks",
            verify_map=verify_map,
            outlier_filter=filters_outliers(sim, outlier_filter),
            estimate=estimate,
            mission=name_of(mission),
            link=resolved_path(link),
        )
        occupancy, reference = request.new_map(map_memory_mb), request.new_reference()
    _require_writable(out)
    with alone_in(out):
        checkpoint = Checkpoint(out)
        checkpoint.remove_leftovers()
        if (earlier := checkpoint.set_aside()) is not None:
            terminal.message(f"an unfinished survey was in {out}; it is kept in {earlier}")
        recorder = None
        if record is not None:
            from uwsim.survey.from_recording import survey_recorder  # here, since recording formats take long to import

            recorder = survey_recorder(sim, record, request, record_topics).start()
        return _SurveyRun(
            sim, occupancy, reference, request, checkpoint, autosave_s, terminal, kind, recorder, mission, close_loops
        ).run()


def resume_survey(
    out: Path,
    *,
    threads: int | None = None,
    autosave_s: float = AUTOSAVE_S,
    map_memory_mb: float | None = None,
    report: str = "full",
    **arguments: Any,
) -> SurveyRecord:
    """Continue the survey that `run_survey` last saved in `out`; the map is the same as without the interruption.

    arguments: the other arguments of run_survey; those that are not None must equal those of the saved survey.
    Raises ValueError when there is nothing to resume or an argument differs; otherwise as run_survey.
    """
    _require_interval(autosave_s)
    kind = _checked_report(report)
    terminal = Terminal()
    checkpoint = Checkpoint(out)
    checkpoint.require_one()
    with alone_in(out):
        with terminal.status(f"resuming {out}"):
            saved = checkpoint.read(map_memory_mb)
            saved.request.require_same(arguments)
            sim = saved.request.new_simulator(threads)
        _require_writable(out)
        checkpoint.remove_leftovers()
        run = _SurveyRun(
            sim, saved.occupancy, saved.reference, saved.request, checkpoint, autosave_s, terminal, kind,
            mission=saved.request.mission,
        )  # fmt: skip
        return run.run(saved)


def _require_surveyable(scenario: Scenario) -> None:
    required_survey(scenario)
    first = scenario.vehicles[0]
    if first.model.sonar is None:
        raise ValueError(f"vehicle '{first.name}': has no sonar to survey with")


def _require_interval(autosave_s: float) -> None:
    if not (math.isfinite(autosave_s) and autosave_s >= 0.0):
        raise ValueError(f"autosave_s = {autosave_s} s: must be 0 (never) or more")


def _checked_report(report: str) -> Report:
    for known in REPORTS:
        if report == known:
            return known
    raise ValueError(f"report = {report}: must be one of {', '.join(REPORTS)}")


def _require_writable(folder: Path) -> None:
    """Raise OSError, before a long flight, if the results could not be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(f"--out {folder}: cannot write there: {error.strerror}") from error
    for name in (MAP, REPORT, TRACK, SUMMARY):
        if (folder / name).exists() and not (folder / name).is_file():
            raise OSError(f"--out {folder}: '{name}' in it is not a file")


@dataclass
class _SurveyRun:
    """A survey that is ready to fly."""

    sim: Simulator
    occupancy: OccupancyMap
    reference: OccupancyMap | None
    request: SurveyRequest
    checkpoint: Checkpoint
    autosave_s: float
    terminal: Terminal
    report: Report
    recorder: Recorder | None = None
    mission: OwnMission | str | None = None
    close_loops: bool = False
    ahead: SurfaceAhead | None = None

    def run(self, saved: SavedSurvey | None = None) -> SurveyRecord:
        """Fly, from the saved state if there is one; write the map whatever happens; verify it; write the results."""
        out, terminal = self.checkpoint.out, self.terminal
        autosave = Autosave(self.checkpoint, self.request, self.autosave_s, terminal.message)
        for stale in RESULT_FILES:  # of an earlier survey, which would not belong to this map
            (out / stale).unlink(missing_ok=True)
        try:
            record = self._fly(autosave, saved)
        except BaseException as error:
            try:
                self._write_map()
                self._close_recording(None)
            except OSError as second:
                raise OSError(f"{error}; and {second}") from error
            raise
        if autosave.in_haste:
            return self._leave(record, autosave)
        ashore = self._map_ashore(record)
        rendered = render_ahead(self.sim, self.occupancy, record) if self.report == "full" else None
        is_scored = self.report != "none"
        scoring_or_none = Scoring(self.sim, self.occupancy, record, ashore, self.ahead) if is_scored else nullcontext()
        with scoring_or_none as scoring:
            self._write_map()
            return self._finish(record, autosave, scoring, rendered)

    def _leave(self, record: SurveyRecord, autosave: Autosave) -> SurveyRecord:
        """Write the map alone: whoever sends SIGTERM does not wait for a report."""
        self._write_map()
        self._close_recording(record)
        self.terminal.message(f"terminated; {self._what_is_left(autosave)}")
        return replace(record, stopped_because=INTERRUPTED)

    def _what_is_left(self, autosave: Autosave) -> str:
        resumable = self.checkpoint.exists and autosave.failure is None
        hint = "; uwsim survey --resume continues" if resumable else ""
        return f"{self.checkpoint.out / MAP} holds everything seen so far{hint}"

    def _map_ashore(self, record: SurveyRecord) -> OccupancyMap | None:
        """Make the station's map, and write it. Raises OSError."""
        if record.ashore is None:
            return None
        made = record.ashore.made_map(self.occupancy.resolution_m, self.request.engine)
        made.write(self.checkpoint.out / MAP_ASHORE)
        return made

    def _finish(
        self, record: SurveyRecord, autosave: Autosave, scoring: Scoring | None, rendered: Future[TruthAndMap] | None
    ) -> SurveyRecord:
        """Once the map is written, verify it and write the results."""
        out, terminal = self.checkpoint.out, self.terminal
        if record.interrupted:
            terminal.message(f"interrupted; {self._what_is_left(autosave)} (Ctrl-C again skips the report)")
        if self.reference is not None:
            record = replace(record, verified=_same_map(self.occupancy, self.reference))
        self._close_recording(record)
        try:
            coverage = write_results(self.sim, self.occupancy, record, out, terminal, self.report, scoring, rendered)
        except OSError as error:
            hint = "; uwsim survey --resume makes the report" if self.checkpoint.exists else ""
            raise OSError(f"{error} ({out / MAP} is complete{hint})") from error
        record = replace(record, coverage=coverage)
        if not record.interrupted:
            self.checkpoint.remove()  # not before the report: if only the report fails, --resume can make it
        if record.verified is not None:
            terminal.result(f"{MAP} {'is identical to' if record.verified else 'DIFFERS from'} that of stock OctoMap")
        return record

    def _fly(self, autosave: Autosave, saved: SavedSurvey | None) -> SurveyRecord:
        sim = self.sim
        if self.report != "none":
            area_m = np.asarray(required_survey(sim.scenario).area_m, np.float64)
            self.ahead = SurfaceAhead(sim.world, sim.scene, self.occupancy.resolution_m, area_m)
        on_ping_taken: TakePing | None = None
        if self.close_loops:
            from uwsim.survey.closed_map import PingKeeper  # here, since scipy takes long to import

            keeper = PingKeeper(sim)
            on_ping_taken = keeper
        if self.recorder is not None:
            from uwsim.survey.from_recording import record_ping

            on_ping_taken = partial(record_ping, self.recorder)
        with self.terminal.flight(sim.scenario.name) as show, stop_on_signals(autosave):
            record = fly_survey(
                sim,
                self.occupancy,
                mission=maker(self.mission),
                on_progress=lambda share: show(share, sim.time_s),
                reference=self.reference,
                supervisor=autosave,
                resume=saved.state if saved is not None else None,
                outlier_filter=self.request.outlier_filter,
                on_ping_taken=on_ping_taken,
                estimate=self.request.estimate,
                ahead=self.ahead,
            )[1]
        return self._closed(keeper.track, record) if self.close_loops and not autosave.in_haste else record

    def _closed(self, track: PingTrack, record: SurveyRecord) -> SurveyRecord:
        """Make the map again from the closed track; say what was closed."""
        from uwsim.survey.closed_map import remake

        with self.terminal.status("closing loops"):
            self.occupancy, record, closed = remake(self.sim, track, self.occupancy, record)
        self.terminal.message(
            f"{len(closed.matches)} of {closed.tried} overlaps of {len(closed.submaps)} submaps matched"
        )
        return record

    def _close_recording(self, record: SurveyRecord | None) -> None:
        """Finish the recording, with the flight's figures if there are some. Raises OSError."""
        if self.recorder is None:
            return
        if record is not None:
            from uwsim.survey.from_recording import note_record

            note_record(self.recorder, record)
        self.recorder.close()

    def _write_map(self) -> None:
        """Write map.bt; if that fails, into a temporary folder. Raises OSError that names what was tried."""
        path = self.checkpoint.out / MAP
        try:
            self.occupancy.write(path)
        except OSError as error:
            tried = str(error)
            if self.checkpoint.exists:
                tried += "; free some space, then uwsim survey --resume continues from the last save"
            try:
                elsewhere = Path(tempfile.mkdtemp(prefix="uwsim-")) / MAP
                self.occupancy.write(elsewhere)
            except OSError as second:
                raise OSError(f"{tried}; nor elsewhere: {second}") from error
            raise OSError(f"{tried}; the map is in {elsewhere}") from error


def _same_map(first: OccupancyMap, second: OccupancyMap) -> bool:
    return first.to_bytes("ot") == second.to_bytes("ot") and first.to_bytes("bt") == second.to_bytes("bt")
