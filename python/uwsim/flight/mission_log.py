"""The log of a flight: one line of JSON per event, written to disk immediately."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import IO

import orjson

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import mark, remove_own_file, require_own
from uwsim.missions.own_vehicle import Event

LOG = "log.jsonl"


class MissionLog:
    """The events of a flight, in order; if there is an output folder, also written to a new file as they occur.

    If the disk is full, the flight continues with the events in memory.
    """

    def __init__(self, out: Path | None) -> None:
        self.events: list[Event] = []
        self._path = None if out is None else out / LOG
        self._file: IO[bytes] | None = None
        if self._path is not None:
            require_own(self._path)
            self._file = self._path.open("wb", buffering=0)
            mark(self._path, unfinished=True)

    def add(self, event: Event) -> None:
        """Add an event."""
        self.events.append(event)
        if self._file is None or self._path is None:
            return
        try:
            self._file.write(_line(event))
        except OSError:
            self.close()
            remove_own_file(self._path)  # no incomplete file is left behind; see rewrite_if_lost

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None
            assert self._path is not None
            mark(self._path)


def rewrite_if_lost(out: Path, events: Iterable[Event]) -> None:
    """Rewrite the events if their file is missing because its folder was deleted or the disk was full.

    Raises OSError.
    """
    if not (out / LOG).exists():
        write_atomically(out / LOG, b"".join(map(_line, events)))


def _line(event: Event) -> bytes:
    line = {"time_s": round(event.time_s, 6), "vehicle": event.vehicle, "event": event.name, **_values(event)}
    return orjson.dumps(line, option=orjson.OPT_APPEND_NEWLINE)


def _values(event: Event) -> dict[str, object]:
    return {"values": event.values} if event.values else {}
