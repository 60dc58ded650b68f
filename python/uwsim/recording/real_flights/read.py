"""The readers of logs of real flights, by content."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from uwsim.base.texts.text_file import first_bytes
from uwsim.recording.real_flights.columns import Columns, read_columns
from uwsim.recording.real_flights.dataflash import is_dataflash, read_dataflash
from uwsim.recording.real_flights.flight_log import FlightLog
from uwsim.recording.real_flights.glider_log import is_glider, read_glider
from uwsim.recording.real_flights.odometry_bag import is_bag, read_bag
from uwsim.recording.real_flights.telemetry_log import is_telemetry, read_telemetry

HEAD_BYTES = 64


class LogReader(NamedTuple):
    """A kind of log: whether a path, by its first bytes, is one; and its reader."""

    accepts: Callable[[Path, bytes], bool]
    read: Callable[[Path], FlightLog]


READERS = (
    LogReader(is_dataflash, read_dataflash),
    LogReader(is_bag, read_bag),
    LogReader(is_glider, read_glider),
    LogReader(is_telemetry, read_telemetry),
)
"""The kinds that are known by their content; what is none of them, nor of OTHERS, is a table."""
OTHERS = {
    b"ULog\x01\x12\x35": "a ULog of PX4 (ulog2csv reads it)",
    b"\x89HDF": "HDF5",
    b"PK\x03\x04": "a ZIP archive",
}


def reader_of(path: Path) -> LogReader | None:
    """Return the reader that a path's content asks for; None for a table. Raises OSError, or ValueError for others."""
    head = b"" if path.is_dir() else first_bytes(path, HEAD_BYTES)
    found = next((each for each in READERS if each.accepts(path, head)), None)
    if found is None and (kind := next((OTHERS[mark] for mark in OTHERS if head.startswith(mark)), None)):
        raise ValueError(f"{path}: is {kind}, which is not read: make a table of it, see --columns")
    return found


def read_flight(path: Path, columns: str | None = None) -> FlightLog:
    """Read a log. columns: of a table, see Columns. Raises OSError, and ValueError with the file and the rule."""
    stated = None if columns is None else Columns.of(columns)
    reader = reader_of(path)
    if reader is None:
        return read_columns(path, stated)
    if stated is not None:
        raise ValueError(f"{path}: --columns: is for tables, which this is not")
    return reader.read(path)
