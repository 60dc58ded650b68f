"""The sentences of NMEA 0183 (IEC 61162-1) as text, from values in SI units; None is an empty field.

Headings and bearings are in radians, clockwise from true north.
"""

from __future__ import annotations

import math
from datetime import datetime
from functools import reduce
from operator import xor
from typing import NamedTuple

INTEGRATED, SOUNDER, POSITIONING = "IN", "SD", "SN"
"""Talkers: integrated navigation, depth sounder, positioning system of another kind."""
MEASURED, ESTIMATED, NO_FIX = 1, 6, 0  # quality in GGA
KM_H, KNOTS, FEET, FATHOMS = 3.6, 3600 / 1852, 1 / 0.3048, 1 / 1.8288  # per m/s, m/s, m, m


class Fix(NamedTuple):
    """A position [deg, WGS 84], and its height above the water [m]. is_measured: by satellites."""

    latitude_deg: float
    longitude_deg: float
    height_m: float
    is_measured: bool = False


class Motion(NamedTuple):
    """A velocity over ground: course [rad] and speed [m/s]."""

    course_rad: float
    speed_m_s: float


def sentence(talker: str, kind: str, *fields: object) -> str:
    """Return a sentence with its checksum, the exclusive or of all characters between $ and *."""
    body = ",".join([talker + kind, *("" if field is None else str(field) for field in fields)])
    return f"${body}*{reduce(xor, body.encode()):02X}\r\n"


def zda(time: datetime) -> str:
    """Return time and date in UTC, which is the local time, too."""
    return sentence(INTEGRATED, "ZDA", _time(time), f"{time:%d}", f"{time:%m}", f"{time:%Y}", "00", "00")


def gga(time: datetime, fix: Fix | None) -> str:
    """Return the position: its quality is 1 (by satellites, none of them simulated), 6 (estimated), or 0 without."""
    if fix is None:
        return sentence(INTEGRATED, "GGA", _time(time), *[None] * 4, NO_FIX, "00", *[None] * 7)
    height = f"{fix.height_m:.2f}"
    return sentence(
        INTEGRATED,
        "GGA",
        _time(time),
        *_place(fix),
        MEASURED if fix.is_measured else ESTIMATED,
        "00",
        None,
        height,
        "M",
        *[None] * 4,
    )


def rmc(time: datetime, fix: Fix | None, motion: Motion) -> str:
    """Return position, speed, course and date, with the mode A (by satellites), E (estimated) or N (no position)."""
    speed, course = f"{motion.speed_m_s * KNOTS:.3f}", _degrees(motion.course_rad)
    place, (status, mode) = ([None] * 4, "VN") if fix is None else (_place(fix), "AA" if fix.is_measured else "AE")
    return sentence(INTEGRATED, "RMC", _time(time), status, *place, speed, course, f"{time:%d%m%y}", None, None, mode)


def vtg(motion: Motion) -> str:
    """Return course and speed over ground."""
    knots, km_h = (f"{motion.speed_m_s * unit:.3f}" for unit in (KNOTS, KM_H))
    return sentence(INTEGRATED, "VTG", _degrees(motion.course_rad), "T", None, "M", knots, "N", km_h, "K", "E")


def hdt(heading_rad: float) -> str:
    """Return the true heading."""
    return sentence(INTEGRATED, "HDT", _degrees(heading_rad), "T")


def dpt(below_m: float | None, depth_m: float | None, range_max_m: float) -> str:
    """Return the height above the bed, the transducer's own depth, and the largest height that can be measured.

    The sum of the first two is the depth of the water.
    """
    return sentence(SOUNDER, "DPT", *(_number(value) for value in (below_m, depth_m, range_max_m)))


def dbt(below_m: float | None) -> str:
    """Return the height above the bed in feet, metres and fathoms."""
    feet, metres, fathoms = (None if below_m is None else f"{below_m * unit:.2f}" for unit in (FEET, 1, FATHOMS))
    return sentence(SOUNDER, "DBT", feet, "f", metres, "M", fathoms, "F")


def ttm(number: int, name: str, time: datetime, seen: tuple[float, float] | None) -> str:
    """Return a tracked target: seen is its horizontal distance [m] and bearing from the station, None if it is lost."""
    distance, bearing = (None, None) if seen is None else (f"{seen[0] / 1000:.4f}", _degrees(seen[1]))
    status = "L" if seen is None else "T"
    motion = [None, None, "T", None, None]  # speed, course, closest approach: a fix is of a position alone
    return sentence(
        POSITIONING, "TTM", f"{number:02d}", distance, bearing, "T", *motion, "K", name, status, None, _time(time), "A"
    )


def _time(time: datetime) -> str:
    return f"{time:%H%M%S}.{time.microsecond // 10_000:02d}"


def _number(value: float | None) -> str | None:
    return None if value is None else f"{value:.2f}"


def _degrees(angle_rad: float) -> str:
    return f"{round(math.degrees(angle_rad), 2) % 360:.2f}"


def _place(fix: Fix) -> list[str]:
    """Return latitude, N or S, longitude, E or W, in degrees and minutes to 1e-6 minute (2 mm)."""
    longitude = math.remainder(fix.longitude_deg, 360)
    found = []
    for value, width, letters in ((fix.latitude_deg, 2, "NS"), (longitude, 3, "EW")):
        whole, micro = divmod(round(abs(value) * 60e6), 60_000_000)
        found += [f"{whole:0{width}d}{micro / 1e6:09.6f}", letters[value < 0]]
    return found
