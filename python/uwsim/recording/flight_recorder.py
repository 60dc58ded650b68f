"""Records a flight: its channels or, for a planned mission such as a survey, every ping used for the map."""

from __future__ import annotations

import dataclasses
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from uwsim import _core
from uwsim.channels import Channel, Table
from uwsim.channels.ros.own_types import SONAR_PING
from uwsim.flight.attachment import Attachment, Departure
from uwsim.flight.pinging import ping_interval_s
from uwsim.flight.record import RECORDING, FlightRecord
from uwsim.flight.request import FlightRequest
from uwsim.recording.mcap_sink import SURVEY
from uwsim.recording.pings import NAME, ping_message
from uwsim.recording.recorder import MAP_TYPE, Recorder
from uwsim.simulator.simulator import Simulator

PINGS = Channel(NAME, SONAR_PING, "out", "each ping of the survey, with the poses of body and sonar in the world")
NOTED = (
    "mission", "scenario", "seed", "estimate", "step_s", "ended_because", "ended_early", "simulated_s", "wall_s",
    "sonar_model", "threads", "stage_wall_s", "echo_count", "range_max_m", "voxel_m", "outlier_filter",
    "ping_interval_s", "ping_interval_requested_s", "pings_with_warning", "warning_limits_m", "verified",
    "lanes_left_out", "planned",
)  # fmt: skip
"""Fields of the record that cannot be derived from the pings."""


class FlightRecorder(Attachment):
    """Records one flight. table: the recorded channels; None if pings are recorded."""

    def __init__(self, recorder: Recorder, table: Table | None) -> None:
        self._recorder, self.table = recorder, table
        self.on_ping = self._record_ping if table is None else None
        self._measured: AbstractContextManager[object] = nullcontext()

    def start(self) -> None:
        """Start recording. Raises OSError."""
        if self.timer is not None:
            self._measured = self.timer.measure(RECORDING)
        self._recorder.start(self._measured)

    def _record_ping(self, ping: _core.Ping, panel: _core.Telemetry, world_from_body: Any) -> None:
        with self._measured:
            record_ping(self._recorder, ping, panel, world_from_body)

    def ended(self, flown: FlightRecord) -> FlightRecord:
        """Append to a recording of pings those values that cannot be derived from them."""
        if self.table is None:
            note_record(self._recorder, flown)
        return flown

    def try_close(self) -> OSError | None:
        """Complete and close the file; return the error if writing failed."""
        return self._recorder.try_close()


def recorder_of(flight: Departure, path: Path, topics: tuple[str, ...] | None) -> FlightRecorder:
    """Return the recorder of a flight; by default, it records all channels except pictures and maps.

    The map and report of a planned flight can be rebuilt from its recording. Raises ValueError.
    """
    assert flight.request is not None
    sim = flight.sim
    if flight.is_planned:
        return FlightRecorder(survey_recorder(sim, path, flight.request, topics), None)
    table = Table(sim)
    costly = [c.name for c in table.channels if c.delivery.late or c.type == MAP_TYPE] if topics is None else []
    return FlightRecorder(Recorder(sim, path, topics=topics, without=costly, shared=table), table)


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
