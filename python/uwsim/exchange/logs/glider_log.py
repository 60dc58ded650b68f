"""Logs of Slocum gliders (.dbd, .mbd, .sbd), read by dbdreader: GPL, so that it is not installed with uwsim.

A log's description is in a file of its own (.cac), in the folder `cac` beside it, or beside it. Masterdata of Teledyne
Webb has the units: attitude [rad], depth [m], place [deg], oil or water pumped [cm3], battery's place [in], forward.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.recording.real_flights.flight_log import (
    LONGEST_S,
    MOST_BYTES,
    MOST_ROWS,
    FlightLog,
    Series,
    attitude_from_ned,
    series_of,
)

MAGIC = b"dbd_label:"
KIND = "a glider's log (.dbd)"
PUMPS = ("m_ballast_pumped", "m_de_oil_vol")
APART_S, LONG_GAP_S = 0.9, 10.0
"""A glider logs every few seconds; in between, up to LONG_GAP_S, its slow motion is interpolated."""
FULL_CM3, TRAVEL_MM, MM_PER_INCH = 250.0, 50.0, 25.4
"""Commands of 1 of the packaged `slocum`."""


def read_glider(path: Path) -> FlightLog:
    """Read a log. Raises OSError, and ValueError with the file and the rule."""
    if find_spec("dbdreader") is None:
        raise ValueError(f"{path}: {KIND}: needs 'dbdreader', which is not installed: pip install dbdreader")
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"{path}: {KIND}: {path.stat().st_size} bytes: must have at most {MOST_BYTES}")
    cache = path.parent / "cac" if (path.parent / "cac").is_dir() else path.parent
    library = import_module("dbdreader")
    try:
        log = library.DBD(str(path), cacheDir=str(cache))
    except library.DbdError as error:
        raise ValueError(f"{path}: {KIND}: cannot be read with the descriptions (.cac) in {cache}: {error}") from None
    try:
        return flight_of(path, log, library.DbdError)
    finally:
        log.close()


def flight_of(path: Path, log: Any, failure: type[Exception]) -> FlightLog:
    """Return the log of an open file. failure: what its `get` raises for a name that it lacks. Raises ValueError."""

    def of(name: str) -> tuple[Floats, Floats] | None:
        try:
            times_s, values = log.get(name)
        except failure:
            return None
        times_s, values = np.asarray(times_s, np.float64), np.asarray(values, np.float64)
        values = np.unwrap(values) if name == "m_heading" else values
        return (times_s, values) if 1 < len(times_s) <= MOST_ROWS and np.ptp(times_s) <= LONGEST_S else None

    def together(names: tuple[str, ...]) -> tuple[Floats, Floats] | None:
        """Return times and values (n, k), interpolated between those of the first."""
        found = [of(name) for name in names]
        if any(each is None for each in found):
            return None
        known = [each for each in found if each is not None]
        times_s = _closer(known[0][0])
        return times_s, np.column_stack([np.interp(times_s, each[0], each[1]) for each in known])

    series: dict[str, Series] = {}

    def take(quantity: str, found: tuple[Floats, Floats] | None, source: str, names: tuple[str, ...] = ()) -> None:
        if found is not None and (made := series_of(path, found[0], found[1], source, names)) is not None:
            series[quantity] = made

    attitude = together(("m_roll", "m_pitch", "m_heading"))
    if attitude is not None:
        attitude = attitude[0], attitude_from_ned(attitude[1])
    take("attitude", attitude, "m_roll, m_pitch, m_heading [rad]")
    take("depth", together(("m_depth",)), "m_depth [m]")
    take("place", together(("m_lat", "m_lon")), "m_lat, m_lon [deg], dead reckoned")
    take("altitude", together(("m_altitude",)), "m_altitude [m]")
    pump = next((name for name in PUMPS if of(name) is not None), None)
    assumed = [f"motion between rows up to {LONG_GAP_S:g} s apart is straight: gliders log every few seconds"]
    if pump is not None and (moved := together((pump, "m_battpos"))) is not None:
        shares = moved[1] * [1.0 / FULL_CM3, -MM_PER_INCH / TRAVEL_MM]
        take("thrusters", (moved[0], np.clip(shares, -1.0, 1.0)), f"{pump} [cm3], m_battpos [in]", ("pump", "battery"))
        assumed.append(
            f"commands of 1 are {FULL_CM3:g} cm3 of the pump, and {TRAVEL_MM:g} mm of the battery, aft of its zero; "
            "the glider's ballast is not logged"
        )
    if not series:
        raise ValueError(f"{path}: {KIND}: has none of m_roll, m_depth, m_lat, m_ballast_pumped")
    return FlightLog(path, KIND, series, assumed=tuple(assumed))


def _closer(times_s: Floats) -> Floats:
    """Return times (n,) with others between those that are at most LONG_GAP_S apart."""
    gaps_s = np.diff(times_s)
    counts = np.where(gaps_s <= LONG_GAP_S, np.ceil(gaps_s / APART_S), 1.0)
    parts = [
        np.linspace(t, t + gap, int(n), endpoint=False) for t, gap, n in zip(times_s, gaps_s, counts, strict=False)
    ]
    return np.concatenate([*parts, times_s[-1:]])
