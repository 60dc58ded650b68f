"""Reads a log of a real flight, by its content: by a reader of the group GROUP, or as a table."""

from __future__ import annotations

from pathlib import Path

from uwsim.base.reader import head_of, reader_of
from uwsim.recording.real_flights.columns import Columns, read_columns
from uwsim.recording.real_flights.flight_log import FlightLog

GROUP = "uwsim.kinds.flight_log"
"""Each reader returns a FlightLog of a path."""
OTHERS = {
    b"ULog\x01\x12\x35": "a ULog of PX4 (ulog2csv reads it)",
    b"\x89HDF": "HDF5",
    b"PK\x03\x04": "a ZIP archive",
}
"""Marks of other files, which are no tables."""


def read_flight(path: Path, columns: str | None = None) -> FlightLog:
    """Read a log. columns: of a table, see Columns. Raises OSError, and ValueError with the file and the rule."""
    stated = None if columns is None else Columns.of(columns)
    if (reader := reader_of(GROUP, path)) is not None:
        if stated is not None:
            raise ValueError(f"{path}: --columns: is for tables, which this is not")
        log: FlightLog = reader.read(path)
        return log
    head = head_of(path)
    if kind := next((OTHERS[mark] for mark in OTHERS if head.startswith(mark)), None):
        raise ValueError(f"{path}: is {kind}, which is not read: make a table of it, see --columns")
    return read_columns(path, stated)
