"""Writes Kongsberg's .kmall: surveys of multibeam echo sounders as processing software reads them.

A file holds #IIP with the offsets, #IOP with the comment, #SVP, and for each ping #SPO, #SKM, #SDE, #SVT and #MRZ,
whose layouts are in kmall_layout.py. Kongsberg's detection mode "simulator" marks each ping. Attitudes stand at the
times of the pings, and a ping's beams are formed at the attitude of its transmission. The ellipsoid is at the mean
surface.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import GrowingFile
from uwsim.mapping.files import kmall_layout as layout
from uwsim.mapping.files.georeference import metres_per_degree
from uwsim.mapping.files.kmall_read import SIMULATOR, read_kmall
from uwsim.mapping.files.swath import Array, SoundSpeeds, SurveyFormat, SurveyHead, Swath

EM2040 = 2040
ACTIVE = 1
POSITION_ROLL_HEADING_HEAVE = 0b1111
INVALID_ACCELERATION_ERRORS_DELAYED = 0b1110000
KM_BINARY = 1
EQUIANGLE = 1
SPEED = 1
VERSIONS = {"#SKM": 1, "#SVP": 1, "#SDE": 1, "#MRZ": 3}


class KmallWriter:
    """Writes a survey; see SwathWriter."""

    def __init__(self, path: Path, head: SurveyHead) -> None:
        self._head, self._path, self._file = head, path, GrowingFile(path)
        self._number = 0
        self._last: Swath | None = None

    def add(self, swath: Swath) -> None:
        """Append a swath, its position, attitude and depth. Raises ValueError for more beams than a datagram holds."""
        if len(swath.travel_time_s) > layout.MAX_BEAMS:
            raise ValueError(
                f"--raw {self._path}: {len(swath.travel_time_s)} beams: .kmall holds up to {layout.MAX_BEAMS}"
            )
        if self._last is None:
            self._put("#IIP", swath, *_text(_installation(self._head)))
            self._put("#IOP", swath, *_text(_runtime(self._head)))
            self._put("#SVP", swath, *_profile(self._head.profile, swath))
        sensor = _made(layout.SENSOR, bytes=layout.SENSOR.itemsize, status=ACTIVE)
        self._put("#SPO", swath, sensor, _position(swath))
        self._put("#SKM", swath, *_attitude(swath, self._last))
        self._put("#SDE", swath, sensor, _depth(swath))
        self._put("#SVT", swath, _head_speed(swath))
        self._put("#MRZ", swath, *self._ping(swath))
        self._last = swath
        self._number += 1

    def close(self) -> None:
        """Complete the file."""
        self._file.close()

    def discard(self) -> None:
        """Remove what was written."""
        self._file.discard()

    def _put(self, kind: str, swath: Swath, *parts: np.ndarray[Any, Any] | bytes) -> None:
        body = b"".join(each if isinstance(each, bytes) else each.tobytes() for each in parts)
        size = layout.HEADER.itemsize + len(body) + 4
        seconds, nanoseconds = divmod(swath.time_ns, 10**9)
        header = _made(
            layout.HEADER, bytes=size, type=kind, version=VERSIONS.get(kind, 0), sounder=EM2040, s=seconds,
            ns=nanoseconds,
        )  # fmt: skip
        self._file.write(header.tobytes() + body + size.to_bytes(4, "little"))

    def _ping(self, swath: Swath) -> list[np.ndarray[Any, Any]]:
        count, frequency_hz = len(swath.travel_time_s), self._head.frequency_hz
        edges_deg = np.degrees([swath.beam_rad.max(initial=0.0), swath.beam_rad.min(initial=0.0)])
        ports_m = np.where(swath.is_detected, swath.sounding_m[:, 1], 0.0)
        return [
            _made(layout.PARTITION, of=1, number=1),
            _made(layout.BODY, bytes=layout.BODY.itemsize, ping=self._number % 65536, fans=1, swaths=1, receivers=1),
            _made(
                layout.WRITTEN_PING, bytes=layout.WRITTEN_PING.itemsize, rate_hz=self._rate_hz(swath),
                spacing=EQUIANGLE, detection_mode=SIMULATOR, frequency_hz=frequency_hz, lowest_hz=frequency_hz,
                highest_hz=frequency_hz,
                port_edge_deg=edges_deg[0], starboard_edge_deg=edges_deg[1], port_coverage_deg=edges_deg[0],
                starboard_coverage_deg=edges_deg[1], port_coverage_m=round(ports_m.min(initial=0.0)),
                starboard_coverage_m=round(ports_m.max(initial=0.0)), sectors=1,
                bytes_per_sector=layout.WRITTEN_SECTOR.itemsize, heading_deg=math.degrees(swath.heading_rad) % 360.0,
                sound_speed_m_s=swath.sound_speed_m_s,
                transducer_depth_m=swath.reference_depth_m + float(swath.transducer_m[2]),
                water_level_m=-swath.reference_depth_m, position_method=2, latitude_deg=swath.latitude_deg,
                longitude_deg=swath.longitude_deg, height_m=-swath.reference_depth_m,
            ),
            _made(layout.WRITTEN_SECTOR, frequency_hz=frequency_hz),
            _made(
                layout.RECEIVER, bytes=layout.RECEIVER.itemsize, soundings=count, valid=int(swath.is_detected.sum()),
                bytes_per_sounding=layout.SOUNDING.itemsize, bytes_per_class=4,
            ),
            _soundings(swath),
        ]  # fmt: skip

    def _rate_hz(self, swath: Swath) -> float:
        since_ns = 0 if self._last is None else swath.time_ns - self._last.time_ns
        return 1e9 / since_ns if since_ns > 0 else 0.0


def _made(kind: np.dtype[Any], **values: Any) -> np.ndarray[Any, Any]:
    """Return one record, zero but for the values."""
    record = np.zeros(1, kind)
    for name, value in values.items():
        record[name] = value
    return record


def _text(content: str) -> tuple[np.ndarray[Any, Any], bytes]:
    encoded = content.encode("utf-8")
    return _made(layout.TEXT, bytes=layout.TEXT.itemsize + len(encoded)), encoded


def _installation(head: SurveyHead) -> str:
    """Return the installation's text: sections by commas, values by semicolons, in the order of real files."""
    x, y, z = head.offset_m
    roll, pitch, heading = np.degrees(head.mount_rad)
    place = f"X={x:.4f};Y={y:.4f};Z={z:.4f};R={roll:.4f};P={pitch:.4f};H={heading % 360.0:.4f}"
    zero = "X=0.000;Y=0.000;Z=0.000"
    versions = ",\n".join(f"{part}:0" for part in ("CPU", "VXW", "FILTER", "CBMF", "TX", "RX"))
    return (
        f"OSCV:Empty,EMXV:EM2040,\nPU_0,\nSN=0,\nIP=0.0.0.0:0x00000000,\nUDP=0,\nTYPE=simulated,\nVERSIONS:,\n"
        f"{versions},\nVERSIONS-END,\nSERIALno:\nTX:0,\nRX:0,\nSERIALno-END,\nDCL:0,\nKMALL:{layout.REVISION},\n"
        f"SYSTEM:EM 2040 - Single Tx single Rx,TRAI_TX1:N=0;{place};S=1.0,TRAI_RX1:N=0;V=0;W=0;{place};G=0.00,"
        f"POSI_1:{zero};D=0.000;G=WGS84;T=Datagram;C=On;F=SIM;Q=Off;I=Net port 1;U=ACTIVE,"
        "POSI_2:U=NOT_SET,POSI_3:U=NOT_SET,"
        f"ATTI_1:{zero};R=0.000;P=0.000;H=0.000;D=0.000;M=Rotation;F=KM Binary;I=Net port 2;U=ACTIVE,"
        "ATTI_2:U=NOT_SET,ATTI_3:U=NOT_SET,EMXI:SWLZ=0.000,\n"
    )


def _runtime(head: SurveyHead) -> str:
    """Return the comment as the runtime parameters' text: lines of a name and a value, separated by a colon."""
    values = {"Sonar": head.sonar, "Vehicle": head.vehicle, "Comment": head.comment}
    lines = [f"{name}: {' '.join(value.replace(':', ' -').split())}" for name, value in values.items()]
    return "\n".join(["Runtime parameters", *lines, ""])


def _profile(speeds: SoundSpeeds, swath: Swath) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return #SVP; of more levels than it holds, every second, third, ... one and the last."""
    count = len(speeds.depths_m)
    step = -(-count // (layout.MAX_LEVELS - 1))
    kept = np.unique(np.append(np.arange(0, count, step), count - 1))
    levels = np.zeros(len(kept), layout.LEVEL)
    levels["depth_m"], levels["speed_m_s"] = speeds.depths_m[kept], speeds.speeds_m_s[kept]
    head = _made(
        layout.PROFILE, bytes=layout.PROFILE.itemsize, levels=len(kept), format="S00", s=swath.time_ns // 10**9,
        latitude_deg=swath.latitude_deg, longitude_deg=swath.longitude_deg,
    )  # fmt: skip
    return head, levels


def _position(swath: Swath) -> np.ndarray[Any, Any]:
    seconds, nanoseconds = divmod(swath.time_ns, 10**9)
    return _made(
        layout.POSITION, s=seconds, ns=nanoseconds, latitude_deg=swath.latitude_deg,
        longitude_deg=swath.longitude_deg, speed_m_s=swath.speed_m_s,
        course_deg=math.degrees(swath.course_rad) % 360.0, height_m=-swath.reference_depth_m,
    )  # fmt: skip


def _depth(swath: Swath) -> np.ndarray[Any, Any]:
    return _made(
        layout.DEPTH, depth_m=swath.reference_depth_m, raw_m=swath.reference_depth_m, scale=1.0,
        latitude_deg=swath.latitude_deg, longitude_deg=swath.longitude_deg,
    )  # fmt: skip


def _head_speed(swath: Swath) -> np.ndarray[Any, Any]:
    seconds, nanoseconds = divmod(swath.time_ns, 10**9)
    return _made(
        layout.HEAD_SPEED, bytes=20, status=ACTIVE, samples=1, bytes_per_sample=24, contents=SPEED, s=seconds,
        ns=nanoseconds, speed_m_s=swath.sound_speed_m_s,
    )  # fmt: skip


def _attitude(swath: Swath, last: Swath | None) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return #SKM with one sample; rates are those since the last swath, zero for the first."""
    seconds, nanoseconds = divmod(swath.time_ns, 10**9)
    angles = np.degrees([swath.roll_rad, swath.pitch_rad, swath.heading_rad])
    rates, sinking_m_s = np.zeros(3), 0.0
    if last is not None and swath.time_ns > last.time_ns:
        since_s = 1e-9 * (swath.time_ns - last.time_ns)
        turned = angles - np.degrees([last.roll_rad, last.pitch_rad, last.heading_rad])
        rates = ((turned + 180.0) % 360.0 - 180.0) / since_s
        sinking_m_s = (swath.reference_depth_m - last.reference_depth_m) / since_s
    size = layout.ATTITUDE.itemsize
    sample = _made(
        layout.ATTITUDE, type="#KMB", bytes=size - 12, version=1, s=seconds, ns=nanoseconds,
        status=INVALID_ACCELERATION_ERRORS_DELAYED, latitude_deg=swath.latitude_deg,
        longitude_deg=swath.longitude_deg, height_m=-swath.reference_depth_m, roll_deg=angles[0],
        pitch_deg=angles[1], heading_deg=angles[2] % 360.0, rates_deg_s=rates,
        velocity_m_s=[
            swath.speed_m_s * math.cos(swath.course_rad), swath.speed_m_s * math.sin(swath.course_rad), sinking_m_s,
        ],
        heave_s=seconds, heave_ns=nanoseconds,
    )  # fmt: skip
    head = _made(
        layout.ATTITUDES, bytes=layout.ATTITUDES.itemsize, status=ACTIVE, input=KM_BINARY, samples=1,
        bytes_per_sample=size, contents=POSITION_ROLL_HEADING_HEAVE,
    )  # fmt: skip
    return head, sample


def _soundings(swath: Swath) -> np.ndarray[Any, Any]:
    seen = swath.is_detected
    found = np.zeros(len(seen), layout.SOUNDING)

    def known(values: Array) -> Array:
        return np.where(seen & np.isfinite(values), values, 0.0)

    x, y, z = (known(each) for each in swath.sounding_m.T)
    north_m, east_m = metres_per_degree(swath.latitude_deg)
    ahead, aside = math.cos(swath.heading_rad), math.sin(swath.heading_rad)
    found["index"] = found["column_beam"] = np.arange(len(seen))
    found["kind"] = np.where(seen, layout.NORMAL, layout.REJECTED)
    found["method"] = np.where(seen, np.where(swath.is_phase, layout.PHASE, layout.AMPLITUDE), layout.NO_DETECTION)
    found["range_factor"] = 100.0
    found["quality_percent"] = known(100.0 * swath.quality)
    found["vertical_deviation_m"] = known(swath.vertical_deviation_m)
    found["horizontal_deviation_m"] = known(swath.horizontal_deviation_m)
    found["column_angle_deg"] = found["angle_deg"] = np.degrees(swath.beam_rad)
    found["reflectivity1_db"] = found["reflectivity2_db"] = known(swath.amplitude_db)
    found["time_s"] = known(swath.travel_time_s)
    found["latitude_deg"] = (x * ahead - y * aside) / north_m
    found["longitude_deg"] = (x * aside + y * ahead) / east_m
    found["x_m"], found["y_m"] = x, y
    found["z_m"] = np.where(seen, z - swath.reference_depth_m, 0.0)
    return found


KMALL = SurveyFormat("multibeam pings in Kongsberg's EM datagrams", KmallWriter, read_kmall)
