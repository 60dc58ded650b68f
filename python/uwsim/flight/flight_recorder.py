"""The recorder of a flight: its channels, or every ping of the map if the mission is planned, such as a survey."""

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
    """A recording of a flight.

    table: the channels that it shares with a link. take_ping: records a ping; None if the channels do.
    """

    recorder: Recorder
    table: Table | None = None
    take_ping: TakePing | None = None

    def start(self) -> None:
        """Begin. Raises OSError."""
        self.recorder.start()

    def note(self, flown: FlightRecord) -> None:
        """Put what the pings do not say about the flight at the end of the recording."""
        if self.take_ping is not None:
            note_record(self.recorder, flown)

    def try_close(self) -> OSError | None:
        """Finish the file; return the error if something could not be written."""
        return self.recorder.try_close()


def flight_recorder(
    sim: Simulator, path: Path, topics: tuple[str, ...] | None, survey: FlightRequest | None
) -> FlightRecorder:
    """Return what records a flight, by default all channels but pictures and maps.

    survey: the request of a planned flight, whose recording gives its map and report again.
    """
    if survey is not None:
        recorder = survey_recorder(sim, path, survey, topics)
        return FlightRecorder(recorder, take_ping=partial(record_ping, recorder))
    table = Table(sim)
    costly = [c.name for c in table.channels if c.late or c.type == MAP_TYPE] if topics is None else []
    return FlightRecorder(Recorder(sim, path, topics=topics, without=costly, shared=table), table)
