"""Reads Kongsberg's .kmall: #IIP, #SVP, #SKM, #SPO and #MRZ of revisions from F on; other datagrams are passed.

A beam's direction is where the cone of its sector's tilt about the transmitter's forward axis, at transmission, meets
the cone of its angle about the receiver's starboard axis, at reception; in files of a simulator, both are at
transmission. Both sines are scaled from the ping's own sound speed to the profile's at the head.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.texts.text_file import require_regular
from uwsim.mapping.files import kmall_layout as layout
from uwsim.mapping.files.swath import Floats, SoundSpeeds, SurveyFormat, SurveyHead, Swath

SIMULATOR = 100
"""Added to the detection mode of a simulator's pings."""
ACTIVE, INVALID = 1, 16
USED = (b"#IIP", b"#SVP", b"#SKM", b"#SPO", b"#MRZ")
LONGEST = 1 << 26
"""Bytes of a datagram; the longest real ones, of the water column, have some megabytes."""
LIMITS = {"time_s": 60.0, "angle_deg": 180.0, "x_m": 40_000.0, "y_m": 40_000.0, "z_m": 24_000.0}


class _Bytes:
    """A datagram's body, from which records are taken; `rule` raises ValueError with its place in the file."""

    def __init__(self, path: Path, offset: int, body: bytes) -> None:
        self._path, self._offset, self.body = path, offset, body

    def rule(self, rule: str) -> ValueError:
        return ValueError(f"'{self._path}': at byte {self._offset}: {rule}")

    def take(self, kind: np.dtype[Any], at: int, count: int = 1, step: int | None = None) -> np.ndarray[Any, Any]:
        """Return records (count,) that are `step` bytes apart."""
        step = kind.itemsize if step is None else step
        if step < kind.itemsize:
            raise self.rule(f"its records must have {kind.itemsize} bytes or more, have {step}")
        if count < 0 or (at + (count - 1) * step + kind.itemsize > len(self.body) and count):
            raise self.rule("the datagram ends within its records")
        return np.ndarray((count,), kind, self.body, at, (step,)).copy()

    def one(self, kind: np.dtype[Any], at: int) -> Any:
        """Return a record that begins with its own length, in which later revisions have more."""
        record = self.take(kind, at)[0]
        if record["bytes"] < kind.itemsize:
            raise self.rule(f"a record must have {kind.itemsize} bytes or more, states {record['bytes']}")
        return record


@dataclass(frozen=True, eq=False)
class Attitudes:
    """Attitudes of the vehicle: time_s (n,) since 1970, increasing; roll, pitch, unwrapped heading (n, 3) in rad."""

    time_s: Floats
    angles_rad: Floats

    def at(self, times_s: Floats) -> Floats:
        """Return roll, pitch and heading at times (k,), those at the ends beyond them: (k, 3)."""
        return np.column_stack([np.interp(times_s, self.time_s, each) for each in self.angles_rad.T])


@dataclass(frozen=True, eq=False)
class _Survey:
    path: Path
    places: dict[bytes, list[tuple[int, int]]]
    installed: dict[str, dict[str, str]]
    profile: SoundSpeeds
    attitudes: Attitudes
    fixes: Floats
    """Time, speed and course of each position, (n, 3)."""


def read_kmall(path: Path) -> tuple[SurveyHead, Iterator[Swath]]:
    """Return the head and the swaths of a file. Raises OSError, or ValueError with the offset and the rule."""
    places = _places(path)
    for kind, content in ((b"#MRZ", "pings"), (b"#IIP", "the installation"), (b"#SVP", "a sound-speed profile"),
                          (b"#SKM", "attitudes")):  # fmt: skip
        if not places[kind]:
            raise ValueError(f"'{path}': at byte 0: must hold {content} ({kind.decode()}), has none")
    installed = _installed(next(_datagrams(path, places[b"#IIP"][:1]))[1])
    with np.errstate(invalid="ignore"):  # a broken number is refused by its rule, not by the cast
        survey = _Survey(
            path, places, installed, _profile(next(_datagrams(path, places[b"#SVP"][:1]))[1]),
            _attitudes(path, places[b"#SKM"], installed), _fixes(path, places[b"#SPO"]),
        )  # fmt: skip
    offset, mount = _mounted(installed, "RX", 1)
    head = SurveyHead(
        vehicle="", sonar="KMALL", frequency_hz=math.nan, beams=0, max_range_m=math.inf, offset_m=offset,
        mount_rad=mount, profile=survey.profile, comment="",
    )  # fmt: skip
    return head, (_swath(survey, header, data) for header, data in _datagrams(path, places[b"#MRZ"]))


def _places(path: Path) -> dict[bytes, list[tuple[int, int]]]:
    """Return the offset and length of each datagram that is used, by its type."""
    found: dict[bytes, list[tuple[int, int]]] = {kind: [] for kind in USED}
    size, at = path.stat().st_size, 0
    with require_regular(path).open("rb") as file:
        while at < size or at == 0:
            file.seek(at)
            begun = file.read(layout.HEADER.itemsize)
            if len(begun) < layout.HEADER.itemsize or begun[4:5] != b"#":
                raise ValueError(f"'{path}': at byte {at}: not a datagram of .kmall: must have a length and #")
            length = int.from_bytes(begun[:4], "little")
            if not layout.HEADER.itemsize + 4 <= length <= LONGEST or at + length > size:
                raise ValueError(f"'{path}': at byte {at}: a datagram of {length} bytes: must end within the file")
            file.seek(at + length - 4)
            if file.read(4) != begun[:4]:
                raise ValueError(f"'{path}': at byte {at}: a datagram must end with its length again")
            if begun[4:8] in found:
                found[begun[4:8]].append((at, length))
            at += length
    return found


def _datagrams(path: Path, places: list[tuple[int, int]]) -> Iterator[tuple[Any, _Bytes]]:
    """Yield the header and the body of each datagram."""
    with path.open("rb") as file:
        for offset, length in places:
            file.seek(offset)
            content = file.read(length)
            if len(content) < length:
                raise ValueError(f"'{path}': at byte {offset}: the file ends within a datagram")
            header = np.frombuffer(content, layout.HEADER, 1)[0]
            yield header, _Bytes(path, offset, content[layout.HEADER.itemsize : -4])


def _time_s(record: Any) -> float:
    return float(record["s"]) + 1e-9 * float(record["ns"])


def _installed(data: _Bytes) -> dict[str, dict[str, str]]:
    """Return the installation's values by section, such as TRAI_RX1 and X."""
    end = int(data.one(layout.TEXT, 0)["bytes"])
    text = data.body[layout.TEXT.itemsize : end].decode("utf-8", "replace")
    sections = re.findall(r"([A-Z]+[A-Z0-9_]*):([^,\n]*)", text)
    return {name: dict(re.findall(r"([A-Z]+)=([^;]*)", values)) for name, values in sections}


def _numbers(values: dict[str, str], names: str) -> Floats:
    """Return a section's values by their one-letter names, zero where one is missing or not a number."""
    found = np.zeros(len(names))
    for index, name in enumerate(names):
        try:
            found[index] = float(values.get(name, "0"))
        except ValueError:
            continue
    return np.where(np.isfinite(found), found, 0.0)


def _mounted(installed: dict[str, dict[str, str]], array: str, number: int) -> tuple[Floats, Floats]:
    """Return offset [m] and roll, pitch and heading [rad] of an array, TX or RX, or of the head that has both."""
    values = installed.get(f"TRAI_{array}{number}") or installed.get(f"TRAI_HD{number}") or {}
    return _numbers(values, "XYZ"), np.radians(_numbers(values, "RPH"))


def _profile(data: _Bytes) -> SoundSpeeds:
    head = data.one(layout.PROFILE, 0)
    levels = data.take(layout.LEVEL, int(head["bytes"]), int(head["levels"]))
    depths, first = np.unique(levels["depth_m"].astype(np.float64), return_index=True)
    speeds = levels["speed_m_s"][first].astype(np.float64)
    if not len(depths) or not np.isfinite(depths).all() or not ((speeds > 1300.0) & (speeds < 1700.0)).all():
        raise data.rule("its sound-speed profile must have levels of 1300 to 1700 m/s")
    return SoundSpeeds(depths, speeds)


def _attitudes(path: Path, places: list[tuple[int, int]], installed: dict[str, dict[str, str]]) -> Attitudes:
    """Return the attitudes of the active sensor, turned by its mount."""
    samples = []
    for _, data in _datagrams(path, places):
        head = data.one(layout.ATTITUDES, 0)
        if head["status"] & ACTIVE:
            count, step = int(head["samples"]), int(head["bytes_per_sample"])
            samples.append(data.take(layout.ATTITUDE, int(head["bytes"]), count, step))
            system = int(head["system"])
    if not samples or not sum(map(len, samples)):
        raise ValueError(f"'{path}': at byte {places[0][0]}: must have attitudes of an active sensor")
    found = np.concatenate(samples)
    times, first = np.unique(found["s"] + 1e-9 * found["ns"], return_index=True)
    angles = np.radians([found[f"{name}_deg"][first].astype(np.float64) for name in ("roll", "pitch", "heading")]).T
    if not (np.abs(angles) <= math.tau).all():  # false for nan, too
        raise ValueError(f"'{path}': at byte {places[0][0]}: attitudes must be within 360 deg")
    sensor = installed.get(f"ATTI_{system + 1}", {})
    mount = np.radians(_numbers(sensor, "RPH"))
    if mount.any():
        angles = _angles(_turned(angles) @ _turned(mount[None])[0].T)
    if _numbers(sensor, "D").any():
        warnings.warn(f"'{path}': the delay of its attitudes, {sensor['D']} s, is not applied", stacklevel=2)
    angles[:, 2] = np.unwrap(angles[:, 2])
    return Attitudes(times, angles)


def _fixes(path: Path, places: list[tuple[int, int]]) -> Floats:
    found = [
        (_time_s(header), float(fix["speed_m_s"]), math.radians(float(fix["course_deg"])))
        for header, data in _datagrams(path, places)
        for fix in data.take(layout.POSITION, int(data.one(layout.SENSOR, 0)["bytes"]))
    ]
    return np.array(sorted(found), np.float64).reshape(-1, 3)


def _turned(angles_rad: Floats) -> Floats:
    """Return the rotations (n, 3, 3) from forward, starboard, down of a body, for roll, pitch and heading (n, 3)."""
    (cr, cp, ch), (sr, sp, sh) = np.cos(angles_rad).T, np.sin(angles_rad).T
    return np.moveaxis(np.array([
        [ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr],
        [sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr],
        [-sp, cp * sr, cp * cr],
    ]), 2, 0)  # fmt: skip


def _angles(rotations: Floats) -> Floats:
    """Return roll, pitch and heading (n, 3) of rotations (n, 3, 3)."""
    return np.column_stack([
        np.arctan2(rotations[:, 2, 1], rotations[:, 2, 2]), np.arcsin(np.clip(-rotations[:, 2, 0], -1.0, 1.0)),
        np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0]),
    ])  # fmt: skip


def _swath(survey: _Survey, header: Any, data: _Bytes) -> Swath:
    if data.take(layout.PARTITION, 0)[0]["of"] != 1:
        raise data.rule("a ping must be one datagram")
    at = layout.PARTITION.itemsize
    body = data.one(layout.BODY, at)
    at += int(body["bytes"])
    ping = data.one(layout.PING, at)
    at += int(ping["bytes"])
    sectors = data.take(layout.SECTOR, at, int(ping["sectors"]), int(ping["bytes_per_sector"]))
    at += len(sectors) * int(ping["bytes_per_sector"])
    receiver = data.one(layout.RECEIVER, at)
    at += int(receiver["bytes"]) + int(receiver["extra_classes"]) * int(receiver["bytes_per_class"])
    beams = data.take(layout.SOUNDING, at, int(receiver["soundings"]), int(receiver["bytes_per_sounding"]))
    with np.errstate(invalid="ignore"):  # where nothing is required, not-a-number stays
        _require_sound(data, ping, sectors, beams)
        return _of_ping(survey, _time_s(header), body, ping, sectors, beams)


def _require_sound(data: _Bytes, ping: Any, sectors: np.ndarray[Any, Any], beams: np.ndarray[Any, Any]) -> None:
    for name, limit in LIMITS.items():
        if not (np.abs(beams[name]) <= limit).all():  # false for nan, too
            raise data.rule(f"{name} must be within {limit:g} for each beam")
    if len(beams) and not (len(sectors) and beams["sector"].max() < len(sectors)):
        raise data.rule("each beam must be of a sector that the ping has")
    if not (abs(ping["latitude_deg"]) <= 90.0 and abs(ping["longitude_deg"]) <= 180.0):
        raise data.rule("latitude and longitude must be within 90 and 180 deg")
    if not abs(ping["heading_deg"]) <= 360.0:
        raise data.rule("the heading must be within 360 deg")
    if not (abs(ping["water_level_m"]) <= 12_000.0 and abs(ping["transducer_depth_m"]) <= 12_000.0):
        raise data.rule("the head's depth and the water line must be within 12000 m")
    if not (1300.0 < ping["sound_speed_m_s"] < 1700.0 and (np.abs(sectors["tilt_deg"]) <= 90.0).all()):
        raise data.rule("the sound speed must be within 1300 and 1700 m/s, and tilts within 90 deg")


def _of_ping(
    survey: _Survey, time_s: float, body: Any, ping: Any, sectors: np.ndarray[Any, Any], beams: np.ndarray[Any, Any]
) -> Swath:
    times = beams["time_s"].astype(np.float64)
    seen = (beams["kind"] == layout.NORMAL) & (times > 0.0)
    here = survey.attitudes.at(np.array([time_s]))
    heading = math.radians(float(ping["heading_deg"]))
    received = here if ping["detection_mode"] >= SIMULATOR else survey.attitudes.at(time_s + times)
    sent, received = here - [0.0, 0.0, here[0, 2]], received - [0.0, 0.0, here[0, 2]]
    places = [_mounted(survey.installed, name, int(body[key]) + 1) for name, key in (("TX", "transmitter"),
                                                                                  ("RX", "receiver"))]  # fmt: skip
    level = _turned(sent)[0]
    transducer = level @ (0.5 * (places[0][0] + places[1][0]))
    depth_m = -float(ping["water_level_m"])
    profile = survey.profile
    scale = float(np.interp(depth_m + transducer[2], profile.depths_m, profile.speeds_m_s) / ping["sound_speed_m_s"])
    axes = _where_cones_meet(
        level @ _turned(places[0][1][None])[0][:, 0], _turned(received) @ _turned(places[1][1][None])[0][:, 1],
        scale * np.sin(np.radians(sectors["tilt_deg"][beams["sector"]].astype(np.float64))),
        -scale * np.sin(np.radians(beams["angle_deg"].astype(np.float64))),
    )  # fmt: skip
    nearest = np.searchsorted(survey.fixes[:, 0], time_s, "right") - 1
    speed_m_s, course = survey.fixes[nearest, 1:] if nearest >= 0 else (0.0, heading)
    soundings = np.column_stack([beams[f"{name}_m"].astype(np.float64) for name in "xyz"])
    soundings[:, 2] += depth_m

    def known(values: Floats) -> Floats:
        return np.where(seen & (values != 0.0), values.astype(np.float64), np.nan)

    return Swath(
        time_ns=round(time_s * 1e6) * 1000, latitude_deg=float(ping["latitude_deg"]),
        longitude_deg=float(ping["longitude_deg"]), reference_depth_m=depth_m, heading_rad=heading,
        pitch_rad=float(sent[0, 1]), roll_rad=float(sent[0, 0]), course_rad=float(course), speed_m_s=float(speed_m_s),
        sound_speed_m_s=float(ping["sound_speed_m_s"]), transducer_m=transducer,
        travel_time_s=np.where(seen, times, np.nan), axes=axes,
        sounding_m=np.where(seen[:, None], soundings, np.nan),
        beam_rad=np.radians(beams["angle_deg"].astype(np.float64)),
        amplitude_db=beams["reflectivity1_db"].astype(np.float64),
        vertical_deviation_m=known(beams["vertical_deviation_m"]),
        horizontal_deviation_m=known(beams["horizontal_deviation_m"]), quality=0.01 * known(beams["quality_percent"]),
        is_phase=beams["method"] == layout.PHASE,
    )  # fmt: skip


def _where_cones_meet(forward: Floats, starboard: Floats, ahead: Floats, aside: Floats) -> Floats:
    """Return downward unit vectors d (n, 3) with d . forward = ahead and d . starboard = aside.

    forward (3,), starboard (1 or n, 3): unit vectors; ahead, aside (n,). Where cones do not meet, the nearest plane.
    """
    starboard = np.broadcast_to(starboard, (len(ahead), 3))
    skew = starboard @ forward
    level = np.maximum(1.0 - skew**2, 1e-12)
    along, across = (ahead - skew * aside) / level, (aside - skew * ahead) / level
    down = np.sqrt(np.maximum(1.0 - along * ahead - across * aside, 0.0) / level)
    found = along[:, None] * forward + across[:, None] * starboard + down[:, None] * np.cross(forward, starboard)
    return np.asarray(found / np.maximum(np.linalg.norm(found, axis=1), 1e-12)[:, None], np.float64)


KMALL = SurveyFormat("multibeam pings in Kongsberg's EM datagrams", read=read_kmall)
