"""Rebuilds a survey's map and report from its recording alone."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, cast

from pydantic import TypeAdapter, ValidationError

from uwsim import _core
from uwsim.channels import Channel
from uwsim.channels.own_types import SONAR_PING
from uwsim.flight.ping_log import PingLog
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import FlightRequest
from uwsim.flight.results import write_results
from uwsim.flight.terminal import Terminal
from uwsim.flight.vehicle_chain import chain_of, filters_outliers, ping_interval_s, survey_area_m
from uwsim.mapping import OccupancyMap
from uwsim.mapping.map_filler import MapFiller
from uwsim.recording.mcap_sink import SURVEY
from uwsim.recording.ping_channel import NAME, ping_message
from uwsim.recording.pings import recorded_pings
from uwsim.recording.reader import Recording
from uwsim.recording.recorder import Recorder
from uwsim.recording.replay import new_simulator
from uwsim.simulator.simulator import Simulator

PINGS = Channel(NAME, SONAR_PING, "out", "each ping of the survey, with the poses of body and sonar in the world")
NOTED = (
    "mission", "scenario", "seed", "estimate", "step_s", "ended_because", "ended_early", "simulated_s", "wall_s",
    "sonar_model", "threads", "stage_wall_s", "echo_count", "range_max_m", "voxel_m", "outlier_filter",
    "ping_interval_s", "ping_interval_requested_s", "pings_with_warning", "warning_limits_m", "verified",
    "lanes_left_out", "planned",
)  # fmt: skip
"""Fields of the record that cannot be derived from the pings."""
RENAMED = {"scenario_name": "scenario", "stopped_because": "ended_because"}
"""New names of fields, keyed by their names in recordings of the first version."""


def survey_recorder(sim: Simulator, path: Path, request: FlightRequest, topics: tuple[str, ...] | None) -> Recorder:
    """Return a recorder for a survey's pings and for `topics`, by default all channels that cannot be derived.

    Pictures can be derived from the other channels; scans, clouds and the map from the pings. Raises ValueError if the
    file is not a .mcap or the survey does not use true poses.
    """
    if path.suffix != ".mcap":
        raise ValueError(f"--record {path}: must end in .mcap for a survey")
    if request.estimate != "truth":
        raise ValueError(f"--record {path}: a survey with --estimate {request.estimate} cannot be recorded")
    notes = {"request": dataclasses.asdict(request)}
    pings = dataclasses.replace(PINGS, rate_hz=1.0 / ping_interval_s(sim, sim.rov.name))
    return Recorder(sim, path, topics=topics, kind=SURVEY, written=[pings], notes=notes)


def record_ping(recorder: Recorder, ping: _core.Ping, panel: _core.Telemetry, world_from_body: Any) -> None:
    """Record a survey ping."""
    recorder.write(PINGS, ping_message(ping, panel, "world", world_from_body, ping.world_from_sonar))


def note_record(recorder: Recorder, record: FlightRecord) -> None:
    """Append to a survey's recording those values of its record that cannot be derived from the pings."""
    recorder.note(record={name: getattr(record, name) for name in NOTED})


def survey_from(recording: Recording, out: Path, report: Path | None) -> int:
    """Write the map of a recorded survey to `out` and its report to the folder `report`; return the number of pings.

    Raises ValueError if the recording ends before the data that a report needs, OSError if a file cannot be read or
    written.
    """
    request = _request_of(recording)
    values = recording.notes.get("record")
    if report is not None and values is None:
        raise ValueError(f"--report: recording '{recording.path}': was cut off before the survey ended")
    sim = new_simulator(recording)
    occupancy, log = _repeated(recording, sim, request)
    occupancy.write(out)
    if report is not None and values is not None:
        record = dataclasses.replace(
            _record_of(values), occupancy=occupancy, area_world_m=log.area_world_m, sample_ping=log.sample,
            pings_world_m={sim.rov.name: log.path_world_m},
        )  # fmt: skip
        write_results(record, sim, report, "full", Terminal())
    return len(log.positions_m)


def _record_of(values: dict[str, Any]) -> FlightRecord:
    """Return the flight record from a recording's notes, without its pings."""
    named = {RENAMED.get(name, name): value for name, value in values.items()}
    return FlightRecord(**{"mission": "survey", "planned": True, **{k: v for k, v in named.items() if k in NOTED}})


def _request_of(recording: Recording) -> FlightRequest:
    """Return the request for a recorded survey; the keys of the first version are a subset of the current ones."""
    try:
        return TypeAdapter(FlightRequest).validate_python(recording.notes.get("request"))
    except ValidationError as error:
        raise ValueError(f"recording '{recording.path}': its survey's request: {error.errors()[0]['msg']}") from None


def _repeated(recording: Recording, sim: Simulator, request: FlightRequest) -> tuple[OccupancyMap, PingLog]:
    """Pass the recorded pings through the survey's processing chain; return the resulting map and log."""
    occupancy = OccupancyMap(resolution_m=request.voxel_m or 1.0, engine=request.engine)
    log, model = PingLog(survey_area_m(sim)), sim.rov.sonar.model
    with MapFiller(occupancy, model.range_max_m, threads=sim.threads) as filler:
        chain = chain_of(sim, sim.rov.name, filler, filters_outliers(sim, sim.rov.name, request.outlier_filter))
        for taken, warnings in recorded_pings(recording, NAME):
            ping, panel = taken.ping, cast(_core.Telemetry, warnings)  # has the fields that the log reads
            points = chain.insert(ping.ranges_m, taken.odom_from_body, taken.odom_from_sonar, ping.time_ns * 1e-9)
            log.add(ping, points, panel, ping.world_from_sonar)
    return occupancy, log
