"""Reads Generic Sensor Format (GSF), by gsfu: our own files, and those of Kongsberg's and other converters.

A file whose angles are all positive and have azimuths states directions of the level vehicle, as gsf.h defines them.
One with signed angles, positive to port, states them about the receiver's array at reception: the direction of a beam
is then where the cone about that array meets the vertical plane of the file's own sounding, since such files do not
state the tilts of their sectors; sin(angle) is scaled from the surface sound speed to the profile's at the transducer.
With the attitude at the time of reception, an EM 302 survey of 20,959 soundings is met to 0.2 % of the depth.
"""

from __future__ import annotations

import math
import struct
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from GSFU import gsfu

from uwsim.base.texts.text_file import first_bytes, require_regular
from uwsim.mapping.files.swath import Floats, SoundSpeeds, SurveyHead, Swath
from uwsim.mapping.ranging import CONFIDENCE, HORIZONTAL_CONFIDENCE

ERRORS = {"VerticalError_m": CONFIDENCE, "HorizontalError_m": HORIZONTAL_CONFIDENCE}  # at 95 %
KNOT_M_S = 1852.0 / 3600.0
DETECTION_PHASE = 2
OPTIONAL = (
    "AlongTrack_m", "BeamAngleForward_deg", "VerticalError_m", "HorizontalError_m", "MeanCalAmplitude_dB",
    "MeanRelAmplitude_dB", "DetectionInfo", "QualityFactor",
)  # fmt: skip
REQUIRED = ("TravelTime_s", "BeamAngle_deg", "Depth_m", "AcrossTrack_m")


@dataclass(frozen=True, eq=False)
class Attitudes:
    """The file's attitudes: time_s (n,) since 1970, increasing; roll, pitch and unwrapped heading (n, 3) in rad."""

    time_s: Floats
    angles_rad: Floats

    def at(self, times_s: Floats) -> Floats | None:
        """Return roll, pitch, heading at times, (k, 3); None if the file does not cover them."""
        if not len(self.time_s) or times_s.min() < self.time_s[0] - 1.0 or times_s.max() > self.time_s[-1] + 1.0:
            return None
        return np.column_stack([np.interp(times_s, self.time_s, each) for each in self.angles_rad.T])


def read_gsf(path: Path) -> tuple[SurveyHead, Iterator[Swath]]:
    """Return the head and the swaths of a file. Raises OSError, or ValueError with the offset and the rule.

    A file that states no transducer's depth, as CARIS writes them, is read with a head at the surface, with a warning.
    """
    file = gsfu.gsf(str(require_regular(path)))
    with _named(path, lambda: 0):
        if first_bytes(path, 12)[8:] != b"GSF-":
            raise ValueError("must begin with a GSF header record")
        file.index_file()
    ids = file.Index["RecordID"].to_numpy()
    if not (ids == gsfu.RecordType.GSF_RECORD_SWATH_BATHYMETRY_PING).any():
        raise ValueError(f"'{path}': at byte 0: must hold pings of a multibeam (record 2), has none")
    profiles = list(_records(path, file, "SOUND_VELOCITY_PROFILE"))
    if not profiles:
        raise ValueError(f"'{path}': at byte 0: must hold a sound-speed profile (record 3), has none")
    parameters: dict[str, str] = next(_records(path, file, "PROCESSING_PARAMETERS"), {"Parameters": {}})["Parameters"]
    attitudes = _attitudes(path, file)
    file.closeFile()  # `_swaths` opens it again
    head = SurveyHead(
        vehicle="", sonar="GSF", frequency_hz=math.nan, beams=0, max_range_m=math.inf,
        offset_m=_offset(parameters.get("APPLIED_TRANSDUCER_OFFSET")), mount_rad=np.zeros(3),
        profile=_profile(path, profiles[0]), comment="",
    )  # fmt: skip
    return head, _swaths(path, file, head, attitudes)


def _records(path: Path, file: Any, kind: str) -> Iterator[dict[str, Any]]:
    index = file.Index
    offsets = index["ByteOffset"][index["RecordID"] == gsfu.resolve_record_type(kind)].tolist()
    found = file.iter_records(kind)
    for offset in offsets:
        with _named(path, partial(int, offset)), np.errstate(all="ignore"):  # `_require_sound` judges the values
            _, _, record = next(found)
        yield record


class _named:  # noqa: N801  # a context manager
    """States the file, the offset and the rule of whatever the decoder raises."""

    def __init__(self, path: Path, offset: Callable[[], int]) -> None:
        self._path, self._offset = path, offset

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        broken = (gsfu.GSFError, struct.error, IndexError, ValueError, KeyError, OverflowError, TypeError, MemoryError)
        if isinstance(error, broken):
            rule = " ".join(str(error).split()) or type(error).__name__
            raise ValueError(f"'{self._path}': at byte {self._offset()}: not a GSF record: {rule}") from None


def _offset(text: str | None) -> Floats:
    """Return forward, starboard, down of the transducer; zeros if the file states none."""
    try:
        values = np.array([float(each) for each in (text or "").split(",")])
    except ValueError:
        return np.zeros(3)
    return values if values.shape == (3,) and np.isfinite(values).all() else np.zeros(3)


def _profile(path: Path, record: dict[str, Any]) -> SoundSpeeds:
    depths, first = np.unique(record["Depth_m"], return_index=True)
    speeds = record["SoundSpeed_mPerSec"][first]
    if not len(depths) or not ((speeds > 1300.0) & (speeds < 1700.0)).all():
        raise ValueError(f"'{path}': its sound-speed profile: must have levels of 1300 to 1700 m/s")
    return SoundSpeeds(depths, speeds)


def _attitudes(path: Path, file: Any) -> Attitudes:
    with _named(path, lambda: 0):
        found = file.read_attitude()
        times_s = found["Time"].astype("datetime64[ns]").astype(np.int64) * 1e-9
        times_s, first = np.unique(times_s, return_index=True)
        angles = np.radians(np.column_stack([found[f"{name}_deg"][first] for name in ("Roll", "Pitch", "Heading")]))
        angles[:, 2] = np.unwrap(angles[:, 2])
    return Attitudes(times_s, angles)


def _swaths(path: Path, file: Any, head: SurveyHead, attitudes: Attitudes) -> Iterator[Swath]:
    for number, record in enumerate(_records(path, file, "SWATH_BATHYMETRY_PING")):
        beams = record["Beams"]
        _require_sound(f"'{path}': ping {number}", record, beams)
        swath = _swath(record, beams, head, attitudes)
        if number == 0 and swath.reference_depth_m + swath.transducer_m[2] == 0.0:
            warnings.warn(
                f"'{path}': states no depth of the transducer: it is taken to be at the surface", stacklevel=2
            )
        yield swath
    file.closeFile()


def _require_sound(where: str, record: dict[str, Any], beams: dict[str, Any]) -> None:
    """Raise ValueError unless a ping has all that its soundings need, within the limits of the Earth's seas."""
    for name in REQUIRED:
        if beams[name] is None or len(beams[name]) != record["NumberBeams"]:
            raise ValueError(f"{where}: must have {name} for each of its beams")
    limits = {"TravelTime_s": 60.0, "BeamAngle_deg": 360.0, "Depth_m": 12_000.0, "AcrossTrack_m": 40_000.0,
              "AlongTrack_m": 40_000.0, "BeamAngleForward_deg": 720.0}  # fmt: skip
    for name, limit in limits.items():
        values = beams[name]
        if values is not None and not (np.abs(values) <= limit).all():  # false for nan, too
            raise ValueError(f"{where}: {name} must be within {limit:g} for each beam")
    for name in ("BeamFlags", *OPTIONAL):
        if beams[name] is not None and len(beams[name]) != record["NumberBeams"]:
            raise ValueError(f"{where}: must have {name} for each of its beams, or for none")
    if not (abs(record["Latitude_deg"]) <= 90.0 and abs(record["Longitude_deg"]) <= 180.0):
        raise ValueError(f"{where}: latitude and longitude must be within 90 and 180 deg")


def _swath(record: dict[str, Any], beams: dict[str, Any], head: SurveyHead, attitudes: Attitudes) -> Swath:
    count, time = record["NumberBeams"], datetime.fromisoformat(record["PingTime"]).timestamp()
    heading, pitch, roll = np.radians([record["Heading_deg"], record["Pitch_deg"], record["Roll_deg"]])
    depth, across = np.asarray(beams["Depth_m"], np.float64), np.asarray(beams["AcrossTrack_m"], np.float64)
    along = np.zeros(count) if beams["AlongTrack_m"] is None else np.asarray(beams["AlongTrack_m"], np.float64)
    flags = np.zeros(count, np.uint8) if beams["BeamFlags"] is None else beams["BeamFlags"]
    time_s = np.asarray(beams["TravelTime_s"], np.float64)
    seen = (flags % 2 == 0) & (time_s > 0.0) & np.isfinite(depth)
    specific = record.get("SensorSpecific", {})
    head_m = float(specific.get("TxTransducerDepth_m") or specific.get("TransducerDepth_m") or math.nan)
    transducer = leveled(head.offset_m, roll, pitch)
    reference_m = (head_m if math.isfinite(head_m) else 0.0) - transducer[2]
    soundings = np.where(seen[:, None], np.column_stack([along, across, depth]), np.nan)
    angle = np.radians(np.asarray(beams["BeamAngle_deg"], np.float64))
    ray = soundings - np.array([*transducer[:2], head_m if math.isfinite(head_m) else 0.0])
    forward = beams["BeamAngleForward_deg"]
    if forward is not None and angle.min(initial=0.0) >= 0.0 and np.ptp(forward) > 90.0:
        axes = _directions(angle, np.radians(forward))
    else:
        received = attitudes.at(time + np.append(time_s, 0.0))  # the last at transmission
        if received is None:
            received = np.tile([roll, pitch, heading], (count + 1, 1))
        received[:, 2] -= received[-1, 2]
        at_head_m_s = float(np.interp(head_m, head.profile.depths_m, head.profile.speeds_m_s))
        surface_m_s = specific.get("SurfaceVelocity_mps") or at_head_m_s
        axes = _received(angle, received[:-1], ray, at_head_m_s / surface_m_s if math.isfinite(head_m) else 1.0)
    error = {name: np.full(count, np.nan) if beams[name] is None else np.asarray(beams[name], np.float64) / factor
             for name, factor in ERRORS.items()}  # fmt: skip
    nothing = np.full(count, np.nan)
    amplitude = next((beams[name] for name in ("MeanCalAmplitude_dB", "MeanRelAmplitude_dB")
                      if beams[name] is not None), nothing)  # fmt: skip
    kind = np.zeros(count) if beams["DetectionInfo"] is None else beams["DetectionInfo"]
    factor = nothing if beams["QualityFactor"] is None else np.asarray(beams["QualityFactor"], np.float64)
    return Swath(
        time_ns=round(time * 1e6) * 1000,
        latitude_deg=record["Latitude_deg"], longitude_deg=record["Longitude_deg"], reference_depth_m=reference_m,
        heading_rad=float(heading), pitch_rad=float(pitch), roll_rad=float(roll),
        course_rad=math.radians(record["Course_deg"]), speed_m_s=record["Speed_kn"] * KNOT_M_S,
        sound_speed_m_s=float(np.interp(reference_m, head.profile.depths_m, head.profile.speeds_m_s)),
        transducer_m=transducer, travel_time_s=np.where(seen, time_s, np.nan),
        axes=axes,
        sounding_m=soundings, beam_rad=angle, amplitude_db=np.asarray(amplitude, np.float64),
        vertical_deviation_m=error["VerticalError_m"], horizontal_deviation_m=error["HorizontalError_m"],
        quality=1e-4 * factor, is_phase=np.asarray(kind) == DETECTION_PHASE,
    )  # fmt: skip


def leveled(offset_m: Floats, roll_rad: float, pitch_rad: float) -> Floats:
    """Return an offset (3,) in a vehicle's axes (forward, starboard, down) in its level axes."""
    x, y, z = offset_m
    down = y * math.sin(roll_rad) + z * math.cos(roll_rad)
    return np.array([
        x * math.cos(pitch_rad) + down * math.sin(pitch_rad), y * math.cos(roll_rad) - z * math.sin(roll_rad),
        down * math.cos(pitch_rad) - x * math.sin(pitch_rad),
    ])  # fmt: skip


def _directions(from_vertical_rad: Floats, azimuth_rad: Floats) -> Floats:
    """Return unit vectors (n, 3), level axes, from angles from the vertical and azimuths from starboard to forward."""
    flat = np.sin(from_vertical_rad)
    return np.column_stack([flat * np.sin(azimuth_rad), flat * np.cos(azimuth_rad), np.cos(from_vertical_rad)])


def _received(angle_rad: Floats, received_rad: Floats, ray_m: Floats, speed_ratio: float) -> Floats:
    """Return unit vectors (n, 3), level axes at transmission, of beams formed at reception.

    angle_rad (n,): about the array, positive to port. received_rad (n, 3): roll, pitch and turn since transmission.
    ray_m (n, 3): to each sounding; it gives the plane of the ray, and which of two solutions is meant.
    """
    roll, pitch, turn = received_rad.T
    array = np.column_stack([
        np.sin(pitch) * np.sin(roll) - np.sin(turn) * np.cos(roll), np.cos(roll) * np.cos(turn),
        np.sin(roll) * np.cos(pitch),
    ])  # fmt: skip
    azimuth, near = np.arctan2(ray_m[:, 0], ray_m[:, 1]), np.arctan2(np.hypot(ray_m[:, 0], ray_m[:, 1]), ray_m[:, 2])
    level = np.sin(azimuth) * array[:, 0] + np.cos(azimuth) * array[:, 1]
    # level sin(x) + down cos(x) = sin(-angle), for the angle x from the vertical
    phase = np.arctan2(array[:, 2], level)
    with np.errstate(invalid="ignore"):
        base = np.arcsin(np.clip(-np.sin(angle_rad) / np.hypot(level, array[:, 2]), -1.0, 1.0))
        found = np.where(np.abs(base - phase - near) < np.abs(math.pi - base - phase - near), base, math.pi - base)
        sine = np.sin(found - phase) * speed_ratio
        return _directions(np.arcsin(np.clip(sine, -1.0, 1.0)), azimuth)
