"""A survey's map and report from its recording alone."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, cast

import numpy as np
from pydantic import TypeAdapter, ValidationError

from uwsim import _core
from uwsim.channels import Channel
from uwsim.channels.own_types import SONAR_PING
from uwsim.mapping import OccupancyMap
from uwsim.recording.mcap_sink import SURVEY
from uwsim.recording.ping_channel import NAME, ping_message
from uwsim.recording.pings import recorded_pings
from uwsim.recording.reader import Recording
from uwsim.recording.recorder import Recorder
from uwsim.recording.replay import new_simulator
from uwsim.simulator import Simulator
from uwsim.survey.fly import hull_box, ping_interval_s, required_survey
from uwsim.survey.ping_log import PingLog
from uwsim.survey.ping_to_map import PingToMap
from uwsim.survey.record import SurveyRecord
from uwsim.survey.request import SurveyRequest
from uwsim.survey.results import Scoring, write_results
from uwsim.survey.terminal import Terminal

PINGS = Channel(NAME, SONAR_PING, "out", "each ping of the survey, with the poses of body and sonar in the world")
FROM_PINGS = ("path_world_m", "position_error_m", "area_world_m", "sample_ping")
"""Fields of the record that the pings give."""


def survey_recorder(sim: Simulator, path: Path, request: SurveyRequest, topics: tuple[str, ...] | None) -> Recorder:
    """Return what records a survey: its own pings and, unless topics say otherwise, all channels that do not follow.

    Pictures follow from the rest, scans, clouds and the map from the pings. Raises ValueError.
    """
    notes = {"request": dataclasses.asdict(request)}
    rate_hz = 1.0 / ping_interval_s(sim, required_survey(sim.scenario))
    pings = dataclasses.replace(PINGS, rate_hz=rate_hz)
    return Recorder(sim, path, topics=topics, kind=SURVEY, written=[pings], notes=notes)


def record_ping(recorder: Recorder, ping: _core.Ping, panel: _core.Telemetry, world_from_body: Any) -> None:
    """Record a ping of the survey."""
    recorder.write(PINGS, ping_message(ping, panel, "world", world_from_body, ping.world_from_sonar))


def note_record(recorder: Recorder, record: SurveyRecord) -> None:
    """Put what the pings do not say about a survey at the end of its recording."""
    values = {f.name: getattr(record, f.name) for f in dataclasses.fields(record) if f.name not in FROM_PINGS}
    recorder.note(record=values)


def survey_from(recording: Recording, out: Path, report: Path | None) -> int:
    """Write the map of a recorded survey to `out`, and its report into a folder; return the number of pings.

    Raises ValueError if the recording was cut off before what a report needs, OSError.
    """
    request = _request_of(recording)
    values = recording.notes.get("record")
    if report is not None and values is None:
        raise ValueError(f"--report: recording '{recording.path}': was cut off before the survey ended")
    sim = new_simulator(recording)
    occupancy, log = _repeated(recording, sim, request)
    occupancy.write(out)
    if report is not None and values is not None:
        report.mkdir(parents=True, exist_ok=True)
        record = SurveyRecord(
            **values, path_world_m=log.path_world_m, area_world_m=log.area_world_m, sample_ping=log.sample
        )
        with Scoring(sim, occupancy, record) as scoring:
            write_results(sim, occupancy, record, report, Terminal(), "full", scoring)
    return len(log.positions_world_m)


def _request_of(recording: Recording) -> SurveyRequest:
    try:
        return TypeAdapter(SurveyRequest).validate_python(recording.notes.get("request"))
    except ValidationError as error:
        raise ValueError(f"recording '{recording.path}': its survey's request: {error.errors()[0]['msg']}") from None


def _repeated(recording: Recording, sim: Simulator, request: SurveyRequest) -> tuple[OccupancyMap, PingLog]:
    """Pass the recorded pings through the survey's own chain."""
    occupancy, log = request.new_map(), PingLog(np.asarray(required_survey(sim.scenario).area_m))
    chain = PingToMap(
        occupancy,
        sim.rov.sonar.model,
        hull_box(sim.scenario),
        threads=sim.threads,
        outlier_filter=bool(request.outlier_filter),
    )
    with chain:
        for taken, warnings in recorded_pings(recording, NAME):
            ping, panel = taken.ping, cast(_core.Telemetry, warnings)  # what the log reads of it
            points = chain.insert(ping.ranges_m, taken.odom_from_body, taken.odom_from_sonar, ping.time_ns * 1e-9)
            log.add(ping, points, panel)
    return occupancy, log
