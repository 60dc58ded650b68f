"""Rebuilds from a recording alone: a survey's map and report, a live run's map, a film, a raw survey."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np
from pydantic import TypeAdapter, ValidationError

from uwsim import _core
from uwsim.base.journal import JUMPS
from uwsim.base.own_files import require_own
from uwsim.channels.families.map import insert_ping
from uwsim.figures.map_film import FILMS, MapFilm, write_film
from uwsim.flight.coverage import growth_row
from uwsim.flight.log import PingLog
from uwsim.flight.pinging import chain_of, filters_outliers, survey_area_m
from uwsim.flight.raw_places import PatchErrors
from uwsim.flight.raw_survey import RawSurvey, raw_writer
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import FlightRequest
from uwsim.flight.results import write_results
from uwsim.flight.terminal import Terminal
from uwsim.mapping import OccupancyMap
from uwsim.mapping.map_filler import MapFiller
from uwsim.recording.flight_recorder import NOTED
from uwsim.recording.head import recorded_head
from uwsim.recording.mcap_sink import SURVEY
from uwsim.recording.pings import NAME, ping_topic, recorded_pings
from uwsim.recording.reader import Recording
from uwsim.recording.replay import execute, new_simulator
from uwsim.scoring.tpu import Uncertainties
from uwsim.simulator.simulator import Simulator


def live_map(
    recording: Recording, vehicle: str | None = None, *, outlier_filter: bool | None = None
) -> tuple[OccupancyMap, int]:
    """Return the map, in odom, of a vehicle's pings since the last jump in time, and the number of pings.

    outlier_filter: overrides the scenario's setting. Raises ValueError.
    """
    topic = ping_topic(recording, vehicle)
    head = recorded_head(recording, topic, outlier_filter)
    occupancy, newest_ns, count = head.new_map(), -1, 0
    for taken, _ in recorded_pings(recording, topic):
        stamp_ns = taken.ping.time_ns
        if stamp_ns == newest_ns:
            continue
        if stamp_ns < newest_ns:
            occupancy, count = head.new_map(), 0
        newest_ns, count = stamp_ns, count + 1
        insert_ping(occupancy, head, taken)
    return occupancy, count


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


def film_of(recording: Recording, out: Path, *, pictures: int = 60, seconds: float = 12.0, width: int = 640) -> int:
    """Write a film of the map beside the truth, with its mean distance from the true surface; return its pictures.

    pictures: at equal numbers of pings. width: of the truth and of the map [pixels]. Raises ValueError or OSError.
    """
    if out.suffix not in FILMS:
        raise ValueError(f"film '{out}': must end in {' or '.join(FILMS)}")
    require_own(out)
    if recording.start.kind != SURVEY:
        raise ValueError(f"recording '{recording.path}': must be that of a survey or of a mission with a map")
    sim, request = new_simulator(recording), request_of(recording)
    area, pings = survey_area_m(sim), recording.info(NAME).message_count
    if area is None or not pings:
        raise ValueError(f"recording '{recording.path}': has no {'pings' if area is not None else 'survey area'}")
    film = MapFilm(sim.world, sim.scene, area, request.voxel_m or 1.0, width)
    due = set(np.linspace(pings, 0, pictures, endpoint=False).round().astype(int).tolist())
    begun: list[int] = []

    def seen(filler: MapFiller, log: PingLog, time_ns: int) -> None:
        begun.append(time_ns)
        if len(begun) in due:
            path, time_s = np.array(log.positions_m), (time_ns - begun[0]) * 1e-9
            filler.when_mapped(lambda: show(filler, path, time_s))

    def show(filler: MapFiller, path: Any, time_s: float) -> None:
        row = growth_row(filler.occupancy, sim, time_s)
        minutes, seconds_left = divmod(round(time_s), 60)
        value = "" if row is None else f", {row.distance_mean_m:.3f} m from the truth"
        film.add(filler.occupancy.occupied_voxels(), path, f"map after {minutes}:{seconds_left:02}{value}")

    repeated(recording, sim, request, seen)
    write_film(out, film.pictures, seconds)
    return len(film.pictures)


def raw_from(
    recording: Recording, topic: str, raw: Path, errors: PatchErrors | None = None, known: Uncertainties | None = None
) -> int:
    """Repeat a run, write its raw survey as in the flight at the times of the pings on a channel; return their number.

    See `raw_writer`. Raises ValueError, also if this build does not repeat the run, or OSError.
    """
    sim = new_simulator(recording)
    if topic not in (NAME, f"{sim.rov.name}/{NAME}"):
        raise ValueError(f"--raw {raw}: is of the first vehicle, '{sim.rov.name}', whose pings are not on {topic}")
    writer = raw_writer(sim, raw, errors, known)
    try:
        for ping in _repeated(recording, sim, topic):
            writer.add(ping, None, np.asarray(sim.rov.pose.world_from_body, np.float64))
        writer.close()
    except BaseException:
        writer.discard()
        raise
    return writer.count


def _repeated(recording: Recording, sim: Simulator, topic: str) -> Iterator[_core.Ping]:
    """Yield the pings of a channel, taken again at the time of each, before its commands."""
    commands = iter(recording.commands())
    command, last = next(commands, None), -1
    for taken, _ in recorded_pings(recording, topic):
        tick = taken.ping.time_ns // recording.step_ns
        while command is not None and command.tick < tick:
            if command.name in JUMPS:
                reason = "its time was reset, at which a raw survey ends"
                raise ValueError(f"recording '{recording.path}': tick {command.tick}: {reason}")
            _step_to(sim, command.tick)
            execute(sim, None, command)
            command = next(commands, None)
        if tick == last:  # a live run's channel may say the latest ping again
            continue
        _step_to(sim, tick)
        last = tick
        ping = sim.rov.sonar.ping()
        if not np.array_equal(ping.ranges_m, taken.ping.ranges_m, equal_nan=True):
            raise ValueError(f"recording '{recording.path}': tick {tick}: this build of uwsim does not repeat the ping")
        yield ping


def _step_to(sim: Simulator, tick: int) -> None:
    if tick > sim.tick:
        sim.step(tick - sim.tick)
