"""Reads soundings from the eXtended Triton Format (XTF X41), with pyxtf's layouts: processed ones, and QPS's angles.

Records of type 17 (XTFBEAMXYZA) state each sounding north and east of the sensor, with its absolute depth: it is kept
as it is, whatever the water. Those of type 28 (XTFQPSMBEENTRY) state the two-way travel time and the angles of each
beam about the head, across (positive to starboard) and tilt (positive forward): the ping's own attitude and the
mounting of the file's bathymetry channel turn them, and the ping's speed of sound makes them straight rays. Positions
are the sensor's own. Other records with soundings, most of them in a vendor's own form, are named and counted.
"""

from __future__ import annotations

import ctypes
import math
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyxtf

from uwsim.base.texts.text_file import require_regular
from uwsim.mapping.files.gsf_read import leveled
from uwsim.mapping.files.swath import Floats, SoundSpeeds, SurveyHead, Swath
from uwsim.mapping.files.xtf_read import DEGREES, KNOT_M_S, XtfFile

PROCESSED, QPS = 17, 28
OF_SOUNDINGS = {PROCESSED, QPS, 2, 5, 9, 10, 14, 16, 18, 19, 22, 25, 26, 27, 60, 61, 62, 65, 66, 67, 68, 69, 73, 74, 78,
                102, 104}  # fmt: skip
"""Types of records with echoes of the bed below (XTF X41, table of XTFPINGHEADER; pyxtf.XTFHeaderType)."""
BATHYMETRY = 3
"""ChanInfo.TypeOfChannel."""
LIMITS = {"offset": (40_000.0, "m"), "depth": (12_000.0, "m"), "time": (60.0, "s"), "angle": (360.0, "deg")}
SPEEDS_M_S, USUAL_M_S = (1300.0, 1700.0), 1500.0


def read_xtf_multibeam(path: Path) -> tuple[SurveyHead, Iterator[Swath]]:
    """Return the head and the swaths of a file. Raises OSError, or ValueError with the offset and the rule.

    Raises ValueError also for a file whose positions are not degrees, or without a record that is read.
    """
    others = Counter[int]()
    first = next(_swaths(path, others), None)
    if first is None:
        has = f"; it has {_counted(others)}" if others else ""
        rule = f"holds no pings of a multibeam in records of type {PROCESSED} or {QPS}{has}"
        raise ValueError(f"'{path}': at byte 0: {rule}")
    speed = SoundSpeeds(np.zeros(1), np.array([first.sound_speed_m_s]))
    head = SurveyHead(
        vehicle="", sonar="XTF", frequency_hz=math.nan, beams=0, max_range_m=math.inf, offset_m=np.zeros(3),
        mount_rad=np.zeros(3), profile=speed, comment="",
    )  # fmt: skip
    return head, _all(path, first.sound_speed_m_s)


def _all(path: Path, speed_m_s: float) -> Iterator[Swath]:
    others = Counter[int]()
    yield from _swaths(path, others, speed_m_s)
    if others:
        warnings.warn(f"'{path}': not read: {_counted(others)}", stacklevel=2)


def _counted(others: Counter[int]) -> str:
    names = {each.value: each.name for each in pyxtf.XTFHeaderType}
    return ", ".join(f"{count:,} of type {kind} ({names[kind]})" for kind, count in sorted(others.items()))


def _swaths(path: Path, others: Counter[int], speed_m_s: float | None = None) -> Iterator[Swath]:
    """Yield the swaths; count others. speed_m_s: of sound, along all rays; by default that of each ping."""
    file = XtfFile(path)
    with require_regular(path).open("rb") as stream:
        header = file.header(stream)
        for at, kind, data in file.records(stream):
            if kind in (PROCESSED, QPS):
                if header.NavUnits != DEGREES:
                    raise file.refused(at, f"NavUnits = {header.NavUnits}: positions must be degrees ({DEGREES})")
                yield _Ping(file, at, kind, data, header).swath(speed_m_s)
            elif kind in OF_SOUNDINGS:
                others[kind] += 1


class _Ping:
    """One record of soundings."""

    def __init__(self, file: XtfFile, at: int, kind: int, data: bytes, header: Any) -> None:
        self._file, self._at, self._kind, self._header = file, at, kind, header
        begin = ctypes.sizeof(pyxtf.XTFPingHeader)
        if len(data) < begin:
            raise file.refused(at, f"a ping of {len(data)} bytes: must have at least {begin}")
        self._ping = ping = pyxtf.XTFPingHeader.from_buffer_copy(data)
        layout = pyxtf.XTFBeamXYZA if kind == PROCESSED else pyxtf.XTFQPSMBEEntry
        count = (len(data) - begin) // ctypes.sizeof(layout)
        stated = int(ping.NumChansToFollow)
        self._beams = np.frombuffer(data, np.dtype(layout), min(stated, count) or count, begin)
        if not (abs(ping.SensorYcoordinate) <= 90.0 and abs(ping.SensorXcoordinate) <= 180.0):
            raise file.refused(at, "latitude and longitude must be within 90 and 180 deg")

    def _values(self, name: str, kind: str) -> Floats:
        """Return a value of each beam; nan where it is no number. Raises ValueError beyond its limit."""
        values = self._beams[name].astype(np.float64)
        limit, unit = LIMITS[kind]
        values[~np.isfinite(values)] = np.nan
        if (np.abs(values) > limit).any():
            raise self._file.refused(self._at, f"{name} must be within {limit:g} {unit} for each beam")
        return values

    def swath(self, speed_m_s: float | None) -> Swath:
        """Return its swath."""
        ping = self._ping
        heading, pitch, roll = (math.radians(_number(each)) for each in (
            ping.SensorHeading, ping.SensorPitch, ping.SensorRoll
        ))  # fmt: skip
        speed, depth_m = speed_m_s or _speed_m_s(ping), _number(ping.SensorDepth)
        if abs(depth_m) > LIMITS["depth"][0]:
            raise self._file.refused(self._at, f"SensorDepth = {depth_m:g} m: must be within {LIMITS['depth'][0]:g} m")
        if self._kind == PROCESSED:
            rays = self._processed(heading, depth_m)
            time_s = 2.0 * np.linalg.norm(rays, axis=1) / speed
            amplitude = self._beams["usAmpl"].astype(np.float64)
        else:
            time_s = self._values("TwoWayTravelTime", "time")
            rays = self._aimed(roll, pitch) * (0.5 * _speed_m_s(ping) * time_s)[:, None]
            time_s *= _speed_m_s(ping) / speed
            amplitude = self._beams["Intensity"].astype(np.float64)
        seen = (time_s > 0.0) & np.isfinite(rays).all(axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            axes = rays / np.linalg.norm(rays, axis=1)[:, None]
        unknown = np.full(len(seen), np.nan)
        return Swath(
            time_ns=self._file.time_ns(self._at, ping), latitude_deg=float(ping.SensorYcoordinate),
            longitude_deg=float(ping.SensorXcoordinate), reference_depth_m=depth_m, heading_rad=heading,
            pitch_rad=pitch, roll_rad=roll, course_rad=heading, speed_m_s=_number(ping.SensorSpeed) * KNOT_M_S,
            sound_speed_m_s=speed, transducer_m=np.zeros(3), travel_time_s=np.where(seen, time_s, np.nan), axes=axes,
            sounding_m=np.where(seen[:, None], rays + np.array([0.0, 0.0, depth_m]), np.nan),
            beam_rad=np.arctan2(-axes[:, 1], axes[:, 2]), amplitude_db=amplitude, vertical_deviation_m=unknown,
            horizontal_deviation_m=unknown, quality=unknown, is_phase=np.zeros(len(seen), bool),
        )  # fmt: skip

    def _processed(self, heading: float, depth_m: float) -> Floats:
        """Return the way to each sounding, level axes (n, 3); zero for beams that were filled up, or without depth."""
        north, east = (self._values(f"dPosOffsetTr{axis}", "offset") for axis in "XY")
        down = self._values("fDepth", "depth")
        forward = north * math.cos(heading) + east * math.sin(heading)
        starboard = east * math.cos(heading) - north * math.sin(heading)
        rays = np.column_stack([forward, starboard, down - depth_m])
        rays[~(down > 0.0)] = 0.0
        return rays

    def _aimed(self, roll: float, pitch: float) -> Floats:
        """Return unit vectors of the beams, level axes (n, 3)."""
        across, tilt = (np.radians(self._values(f"{name}Angle", "angle")) for name in ("Beam", "Tilt"))
        aim = np.array([np.sin(tilt), np.cos(tilt) * np.sin(across), np.cos(tilt) * np.cos(across)])
        heads = [each for each in self._header.every_channel if each.TypeOfChannel == BATHYMETRY]
        if heads:
            head = heads[min(int(self._ping.SubChannelNumber), len(heads) - 1)]
            mount = [math.radians(_number(each)) for each in (head.OffsetRoll, head.OffsetPitch, head.OffsetYaw)]
            forward, starboard, down = leveled(aim, mount[0], mount[1])
            cosine, sine = math.cos(mount[2]), math.sin(mount[2])
            aim = np.array([cosine * forward - sine * starboard, sine * forward + cosine * starboard, down])
        return leveled(aim, roll, pitch).T


def _speed_m_s(ping: Any) -> float:
    """Return the speed of sound: X41 states half of it, for two ways; some programs the whole; else the usual one."""
    stated = _number(ping.SoundVelocity)
    found = next((each for each in (stated, 2.0 * stated) if SPEEDS_M_S[0] <= each <= SPEEDS_M_S[1]), None)
    return USUAL_M_S if found is None else found


def _number(value: float) -> float:
    return float(value) if math.isfinite(value) else 0.0
