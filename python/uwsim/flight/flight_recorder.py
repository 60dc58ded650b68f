"""Records a flight: its channels or, for a planned mission such as a survey, every ping used for the map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from uwsim.channels import Table
from uwsim.flight.from_recording import note_record, record_ping, survey_recorder
from uwsim.flight.pinging import TakePing
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import FlightRequest
from uwsim.recording.recorder import MAP_TYPE, Recorder
from uwsim.simulator.simulator import Simulator


@dataclass(frozen=True)
class FlightRecorder:
    """Records one flight.

    table: the channels, shared with the link; None if pings are recorded. take_ping: records a ping; None if channels
    are recorded.
    """

    recorder: Recorder
    table: Table | None = None
    take_ping: TakePing | None = None

    def start(self) -> None:
        """Start recording. Raises OSError."""
        self.recorder.start()

    def note(self, flown: FlightRecord) -> None:
        """Append to the recording those values that cannot be derived from the pings."""
        if self.take_ping is not None:
            note_record(self.recorder, flown)

    def try_close(self) -> OSError | None:
        """Complete and close the file; return the error if writing failed."""
        return self.recorder.try_close()


def flight_recorder(
    sim: Simulator, path: Path, topics: tuple[str, ...] | None, survey: FlightRequest | None
) -> FlightRecorder:
    """Return a recorder for a flight; by default, it records all channels except pictures and maps.

    survey: the request for a planned flight; its map and report can be rebuilt from the recording.
    """
    if survey is not None:
        recorder = survey_recorder(sim, path, survey, topics)
        return FlightRecorder(recorder, take_ping=partial(record_ping, recorder))
    table = Table(sim)
    costly = [c.name for c in table.channels if c.late or c.type == MAP_TYPE] if topics is None else []
    return FlightRecorder(Recorder(sim, path, topics=topics, without=costly, shared=table), table)
