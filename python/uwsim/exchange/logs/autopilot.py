"""The messages of an autopilot as quantities: which field of which message is what, best source first.

ArduPilot's messages: libraries/AP_Logger/LogStructure.h, ArduSub/Log.cpp (dataflash); common.xml (MAVLink). Angles and
positions are north-east-down, bodies forward-right-down.
"""

from __future__ import annotations

import contextlib
import io
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.extras import need_extra
from uwsim.base.texts.text_file import read_limited
from uwsim.mapping.files.georeference import metres_per_degree
from uwsim.recording.real_flights.flight_log import (
    MOST_BYTES,
    MOST_ROWS,
    QUANTITIES,
    FlightLog,
    Series,
    attitude_from_ned,
    body_from_frd,
    series_of,
    world_from_ned,
)

Rows = Mapping[str, tuple[Floats, Floats]]
"""By message: times [s] (n,) and its fields (n, k), in the order of `fields_of`."""
HORIZONTAL_VELOCITY, RELATIVE, ABSOLUTE, CONSTANT = 2, 8, 16, 128
"""Bits of the filter's status (nav_filter_status; EKF_STATUS_FLAGS): which horizontal quantities it knows."""
PULSE_US = (800.0, 2200.0)
DOWN = 25  # MAV_SENSOR_ROTATION_PITCH_270


class Source(NamedTuple):
    """Where a quantity is. make: converts fields (n, k) to the quantity. assumed: what the source takes for granted."""

    quantity: str
    message: str
    fields: tuple[str, ...]
    unit: str
    make: Callable[[Floats], Floats]
    assumed: str = ""


def _placed(scale: float, metres: float) -> Callable[[Floats], Floats]:
    """Return a converter of latitude, longitude and altitude to metres from the first row."""

    def make(values: Floats) -> Floats:
        lat, lon = values[:, 0] * scale, values[:, 1] * scale
        unknown = (lat == 0) & (lon == 0)
        lat, lon = np.where(unknown, np.nan, lat), np.where(unknown, np.nan, lon)
        first = np.argmax(np.isfinite(lat)) if np.isfinite(lat).any() else 0
        lat_0, lon_0 = float(np.nan_to_num(lat[first])), float(np.nan_to_num(lon[first]))
        north_m, east_m = metres_per_degree(min(max(lat_0, -89.0), 89.0))
        return np.column_stack([(lon - lon_0) * east_m, (lat - lat_0) * north_m, values[:, 2] * metres])

    return make


def _degrees(scale: float) -> Callable[[Floats], Floats]:
    """Return a converter of latitude and longitude; both are 0 where there is no fix."""
    return lambda values: np.where((values != 0).any(axis=1)[:, None], values * scale, np.nan)


def _below(values: Floats) -> Floats:
    """Return ranges [m] of a rangefinder [cm]; NaN where it looks elsewhere than down."""
    return np.where(values[:, 1:] == DOWN, _ranges(0.01 * values[:, :1]), np.nan)


def _ranges(values: Floats) -> Floats:
    return np.where(values > 0, values, np.nan)


def _pulses(values: Floats) -> Floats:
    """Return pulse widths; 0, of an output that is not used, is NaN."""
    return np.where((values >= PULSE_US[0]) & (values <= PULSE_US[1]), values, np.nan)


def _depth_of_altitude(values: Floats) -> Floats:
    return -values


DATAFLASH = (
    Source("attitude", "ATT", ("Roll", "Pitch", "Yaw"), "deg", lambda v: attitude_from_ned(np.radians(v))),
    Source("position", "XKF1", ("PN", "PE", "PD"), "m", world_from_ned),
    Source("position", "NKF1", ("PN", "PE", "PD"), "m", world_from_ned),
    Source("position", "POS", ("Lat", "Lng", "Alt"), "deg, m", _placed(1.0, 1.0)),
    Source("velocity", "XKF1", ("VN", "VE", "VD"), "m/s", world_from_ned),
    Source("velocity", "NKF1", ("VN", "VE", "VD"), "m/s", world_from_ned),
    Source("rates", "IMU", ("GyrX", "GyrY", "GyrZ"), "rad/s", body_from_frd, "the gyro has no bias"),
    Source("depth", "CTUN", ("Alt",), "m, up", _depth_of_altitude),
    Source("depth", "BARO", ("Alt",), "m, up", _depth_of_altitude, "the last barometer is the one in the water"),
    Source("place", "POS", ("Lat", "Lng"), "deg", _degrees(1.0)),
    Source("altitude", "RFND", ("Dist",), "m", _ranges, "the first rangefinder looks down"),
    Source("outputs", "RCOU", tuple(f"C{k}" for k in range(1, 15)), "us", _pulses),
)
TELEMETRY = (
    Source("attitude", "ATTITUDE", ("roll", "pitch", "yaw"), "rad", attitude_from_ned),
    Source("position", "LOCAL_POSITION_NED", ("x", "y", "z"), "m", world_from_ned),
    Source("position", "GLOBAL_POSITION_INT", ("lat", "lon", "relative_alt"), "deg 1e-7, mm", _placed(1e-7, 1e-3)),
    Source("position", "VISION_POSITION_ESTIMATE", ("x", "y", "z"), "m", world_from_ned),
    Source("velocity", "LOCAL_POSITION_NED", ("vx", "vy", "vz"), "m/s", world_from_ned),
    Source("velocity", "GLOBAL_POSITION_INT", ("vx", "vy", "vz"), "cm/s", lambda v: world_from_ned(0.01 * v)),
    Source("rates", "ATTITUDE", ("rollspeed", "pitchspeed", "yawspeed"), "rad/s", body_from_frd),
    Source("depth", "VFR_HUD", ("alt",), "m, up", _depth_of_altitude),
    Source("depth", "AHRS2", ("altitude",), "m, up", _depth_of_altitude),
    Source("place", "GLOBAL_POSITION_INT", ("lat", "lon"), "deg 1e-7", _degrees(1e-7)),
    Source("altitude", "DISTANCE_SENSOR", ("current_distance", "orientation"), "cm", _below),
    Source("altitude", "RANGEFINDER", ("distance",), "m", _ranges, "it looks down"),
    Source("outputs", "SERVO_OUTPUT_RAW", tuple(f"servo{k}_raw" for k in range(1, 17)), "us", _pulses),
)
FROM_FILTER = ("XKF1", "NKF1", "POS", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT")
STATUS = {"XKF4": "SS", "NKF4": "SS", "EKF_STATUS_REPORT": "flags"}
"""The messages whose horizontal values are the filter's, and those with its status."""


def fields_of(sources: tuple[Source, ...]) -> dict[str, tuple[str, ...]]:
    """Return the fields that are read of each message."""
    found: dict[str, tuple[str, ...]] = {name: (field,) for name, field in STATUS.items()}
    for each in sources:
        found[each.message] = (*found.get(each.message, ()), *each.fields)
    return found


def flight_of(
    path: Path,
    kind: str,
    sources: tuple[Source, ...],
    rows: Rows,
    parameters: Mapping[str, float],
    events: list[tuple[float, str]],
) -> FlightLog:
    """Return the log of an autopilot's messages. Raises ValueError for a log that has none of the quantities."""
    fields, found, assumed = fields_of(sources), dict[str, Series](), []
    status = next((rows[name] for name in STATUS if name in rows), None)
    for each in sources:
        if each.quantity in found or each.message not in rows:
            continue
        times_s, table = rows[each.message]
        at = [fields[each.message].index(name) for name in each.fields]
        with np.errstate(all="ignore"):  # a damaged log has any number
            values = each.make(table[:, at])
        is_horizontal = each.message in FROM_FILTER and each.quantity in ("position", "velocity", "place")
        if is_horizontal and status is not None:
            is_up = np.arange(values.shape[1]) == 2
            values = np.where(_known(each.quantity, times_s, *status)[:, None] | is_up, values, np.nan)
        shown = f"{each.fields[0]} to {each.fields[-1]}" if len(each.fields) > 3 else ", ".join(each.fields)
        series = series_of(path, times_s, values, f"{each.message}.{shown} [{each.unit}]")
        if series is None or not np.isfinite(series.values).any():
            continue
        found[each.quantity] = series
        assumed += [f"{each.quantity}: {each.assumed}"] if each.assumed else []
        if is_horizontal and status is None:
            assumed.append(f"{each.quantity}: the log has no status of the filter; its horizontal values are measured")
    if not found:
        wanted = ", ".join(dict.fromkeys(each.message for each in sources))
        raise ValueError(f"{path}: {kind}: has none of {wanted}: must be the log of a vehicle's motion")
    return FlightLog(
        path,
        kind,
        {name: found[name] for name in QUANTITIES if name in found},
        parameters,
        tuple(sorted(events)),
        tuple(assumed),
    )


def _known(quantity: str, times_s: Floats, status_times_s: Floats, status: Floats) -> Floats:
    """Return in which rows the filter knows a horizontal quantity, rather than taking the vehicle to be at rest."""
    bits = np.nan_to_num(status[:, 0]).astype(np.int64)
    wanted = HORIZONTAL_VELOCITY if quantity == "velocity" else RELATIVE | ABSOLUTE
    is_known = ((bits & wanted) != 0) & ((bits & CONSTANT) == 0)
    order = np.argsort(status_times_s, kind="stable")
    at = np.searchsorted(status_times_s[order], times_s, side="right") - 1
    return np.asarray(is_known[order][np.maximum(at, 0)])


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
