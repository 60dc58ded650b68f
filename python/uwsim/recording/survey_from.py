"""Rebuilds a survey's map and report from its recording alone."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from pydantic import TypeAdapter, ValidationError

from uwsim import _core
from uwsim.flight.patch_errors import PatchErrors
from uwsim.flight.ping_log import PingLog
from uwsim.flight.raw_survey import RawSurvey
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import FlightRequest
from uwsim.flight.results import write_results
from uwsim.flight.terminal import Terminal
from uwsim.flight.vehicle_chain import chain_of, filters_outliers, survey_area_m
from uwsim.mapping import OccupancyMap
from uwsim.mapping.map_filler import MapFiller
from uwsim.recording.flight_recorder import NOTED
from uwsim.recording.ping_channel import NAME
from uwsim.recording.pings import recorded_pings
from uwsim.recording.reader import Recording
from uwsim.recording.replay import new_simulator
from uwsim.scoring.tpu import Uncertainties
from uwsim.simulator.simulator import Simulator

Seen = Callable[[MapFiller, PingLog, int], None]
"""Sees how a map grows: the filler, the log of the pings so far, and the time of the last one [ns]."""


def survey_from(
    recording: Recording,
    out: Path,
    report: Path | None,
    *,
    outlier_filter: bool | None = None,
    raw: Path | None = None,
    offsets: PatchErrors | None = None,
    uncertainty: Uncertainties | None = None,
) -> int:
    """Write the map of a recorded survey to `out` and its report to the folder `report`; return the number of pings.

    outlier_filter: overrides the survey's setting. raw, offsets, uncertainty: also write the pings there, with these
    errors and uncertainties; see RawSurvey. Raises ValueError if the recording ends before the data that a report
    needs, OSError if a file cannot be read or written.
    """
    request = request_of(recording)
    if outlier_filter is not None:
        request = dataclasses.replace(request, outlier_filter=outlier_filter)
    values = recording.notes.get("record")
    if report is not None and values is None:
        raise ValueError(f"--report: recording '{recording.path}': was cut off before the survey ended")
    sim = new_simulator(recording)
    survey = None if raw is None else RawSurvey(
        sim, raw, offsets, uncertainty, "truth" if request.estimate == "truth" else "recorded filter"
    )  # fmt: skip
    occupancy, log = repeated(recording, sim, request, raw=survey)
    occupancy.write(out)
    if report is not None and values is not None:
        record = dataclasses.replace(
            _record_of(values), occupancy=occupancy, area_world_m=log.area_world_m, sample_ping=log.sample,
            pings_world_m={sim.rov.name: log.path_world_m}, soundings=None if survey is None else survey.quality,
        )  # fmt: skip
        write_results(record, sim, report, "full", Terminal())
    return len(log.positions_m)


def _record_of(values: dict[str, Any]) -> FlightRecord:
    """Return the flight record from a recording's notes, without its pings."""
    return FlightRecord(**{name: value for name, value in values.items() if name in NOTED})


def request_of(recording: Recording) -> FlightRequest:
    """Return the request for a recorded survey. Raises ValueError."""
    try:
        return TypeAdapter(FlightRequest).validate_python(recording.notes.get("request"))
    except ValidationError as error:
        raise ValueError(f"recording '{recording.path}': its survey's request: {error.errors()[0]['msg']}") from None


def repeated(
    recording: Recording, sim: Simulator, request: FlightRequest, seen: Seen | None = None, raw: RawSurvey | None = None
) -> tuple[OccupancyMap, PingLog]:
    """Pass the recorded pings through the survey's processing chain; return the resulting map and log.

    seen: called after each ping. raw: receives each ping, and is completed.
    """
    occupancy = OccupancyMap(resolution_m=request.voxel_m or 1.0, engine=request.engine)
    log, model = PingLog(survey_area_m(sim)), sim.rov.sonar.model
    with MapFiller(occupancy, model.range_max_m, threads=sim.threads) as filler:
        chain = chain_of(sim, sim.rov.name, filler, filters_outliers(sim, sim.rov.name, request.outlier_filter))
        for taken, warnings in recorded_pings(recording, NAME):
            ping, panel = taken.ping, cast(_core.Telemetry, warnings)  # has the fields that the log reads
            body, sonar, stamp_s = taken.odom_from_body, taken.odom_from_sonar, ping.time_ns * 1e-9
            points = chain.insert(ping.ranges_m, body, sonar, stamp_s, taken.deviation_m)
            log.add(ping, points, panel, ping.world_from_sonar)
            if raw is not None:
                raw.add(ping, panel, body, body)
            if seen is not None:
                seen(filler, log, ping.time_ns)
    if raw is not None:
        raw.close()
    return occupancy, log
