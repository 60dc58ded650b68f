"""Dataflash logs of ArduPilot (.BIN), read by pymavlink."""

from __future__ import annotations

import contextlib
import io
import re
from collections import defaultdict
from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.extras import need_extra
from uwsim.base.texts.text_file import read_limited
from uwsim.exchange.logs.autopilot import DATAFLASH, fields_of, flight_of
from uwsim.recording.real_flights.flight_log import MOST_BYTES, MOST_ROWS, FlightLog

MAGIC = b"\xa3\x95"
KIND = "a dataflash log (.BIN)"
EVENTS_MAX = 500
ENDLESS = re.compile(rb"\xa3\x95\x80.[\x00-\x02][A-Z0-9\x00]{4}", re.DOTALL)
"""A description (FMT) of messages shorter than their own head, of which the library reads one again and again."""


def pass_messages(path: Path, names: Iterable[str], take: Callable[[Any], object]) -> None:
    """Call a function with each message of some types. Raises OSError, or ValueError for a damaged or a large log."""
    need_extra("pymavlink", f"{path}: {KIND}")
    from pymavlink.DFReader import DFReader_binary

    if ENDLESS.search(read_limited(path, str(path), MOST_BYTES)):
        raise ValueError(f"{path}: {KIND}: is damaged: a type of message has no length")
    said, wanted = io.StringIO(), list(names)  # what the library prints of damaged parts
    try:
        with (
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
            closing(DFReader_binary(str(path))) as log,
        ):
            while (message := log.recv_match(type=wanted)) is not None:
                take(message)
    except (OSError, ValueError):
        raise
    except Exception as error:  # the library raises errors of many types for a damaged file
        raise ValueError(f"{path}: {KIND}: is damaged: {type(error).__name__}: {error!s:.100}") from None


def read_dataflash(path: Path) -> FlightLog:
    """Read a dataflash log. Raises OSError, or ValueError for a damaged or a large one."""
    fields = fields_of(DATAFLASH)
    rows: dict[str, list[list[float]]] = defaultdict(list)
    barometers: dict[int, list[list[float]]] = defaultdict(list)
    parameters: dict[str, float] = {}
    events: list[tuple[float, str]] = []

    def take(message: Any) -> None:
        name, time_s = message.get_type(), 1e-6 * float(getattr(message, "TimeUS", np.nan))
        if name == "PARM":
            parameters[str(message.Name)] = float(message.Value)
        elif name == "MSG":
            if len(events) < EVENTS_MAX and np.isfinite(time_s):
                events.append((time_s, str(message.Message)))
        elif name == "BARO" or not (getattr(message, "I", 0) or getattr(message, "C", 0)):  # the first of each
            table = barometers[int(getattr(message, "I", 0))] if name == "BARO" else rows[name]
            if len(table) >= MOST_ROWS:
                raise ValueError(f"{path}: more than {MOST_ROWS} rows of {name}: cut the log")
            table.append([time_s, *(float(getattr(message, each, np.nan)) for each in fields[name])])

    pass_messages(path, [*fields, "PARM", "MSG"], take)
    if barometers:
        rows["BARO"] = barometers[max(barometers)]
    tables = {name: np.array(table, np.float64) for name, table in rows.items()}
    return flight_of(path, KIND, DATAFLASH, {k: (t[:, 0], t[:, 1:]) for k, t in tables.items()}, parameters, events)
