"""Soundings of a ship's multibeam echo sounder and its sound-speed profile, read from Generic Sensor Format.

GSF 3.06, "Generic Sensor Format Specification" (SAIC): big-endian records of a size, a type and their data. A ping has
a header of 56 bytes, then subrecords: scale factors, then arrays of integers, each value / multiplier - offset. Only
the parts needed here are read: the profile, two-way times, depths and positions across and along the ship, flags.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

PING, PROFILE = 2, 3
PING_HEADER_BYTES = 56
SCALES, DEPTH, ACROSS, ALONG, TIME, FLAGS = 100, 1, 2, 3, 4, 16
SIGNED = (ACROSS, ALONG)
REJECTED = 1  # bit of a beam's flags
FILL = 1e-9

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Ping:
    """The accepted soundings of a ping. time_s: two-way travel time. across_m: to starboard."""

    time_s: Floats
    depth_m: Floats
    across_m: Floats
    along_m: Floats


def read_soundings(path: Path) -> tuple[Floats, list[Ping]]:
    """Return the last profile (n, 2) of depth and speed of sound, and all pings. Raises ValueError, OSError."""
    content = path.read_bytes()
    profile, pings, place = np.zeros((0, 2)), [], 0
    scales: dict[int, tuple[float, float]] = {}
    while place + 8 <= len(content):
        size, kind = struct.unpack_from(">II", content, place)
        place += 12 if kind >> 31 else 8  # a checksum follows
        data = content[place : place + size]
        place += size
        if kind & 0x3FFFFF == PROFILE:
            (points,) = struct.unpack_from(">I", data, 24)
            profile = np.frombuffer(data, ">u4", 2 * points, 28).reshape(-1, 2) * 0.01
        elif kind & 0x3FFFFF == PING:
            pings.append(_ping(data, scales))
    if len(profile) == 0 or not pings:
        raise ValueError(f"{path}: has no pings or no sound-speed profile")
    return profile, pings


def _ping(data: bytes, scales: dict[int, tuple[float, float]]) -> Ping:
    """Read a ping. scales: the scale factors of earlier pings, which apply until replaced."""
    (beams,) = struct.unpack_from(">H", data, 16)
    arrays: dict[int, Floats] = {}
    flags, place = np.zeros(beams, np.uint8), PING_HEADER_BYTES
    while place + 4 <= len(data):
        (head,) = struct.unpack_from(">I", data, place)
        kind, size, place = head >> 24, head & 0xFFFFFF, place + 4
        if kind == SCALES:
            (count,) = struct.unpack_from(">I", data, place)
            for k in range(count):
                which, multiplier, offset = struct.unpack_from(">IIi", data, place + 4 + 12 * k)
                scales[which >> 24] = (float(multiplier), float(offset))
        elif kind in (DEPTH, ACROSS, ALONG, TIME):
            raw = np.frombuffer(data, f">{'i' if kind in SIGNED else 'u'}{size // beams}", beams, place)
            multiplier, offset = scales[kind]
            arrays[kind] = raw / multiplier - offset
        elif kind == FLAGS:
            flags = np.frombuffer(data, np.uint8, beams, place)
        place += size
    used = (flags & REJECTED == 0) & (arrays[TIME] > FILL)
    return Ping(*(arrays[kind][used] for kind in (TIME, DEPTH, ACROSS, ALONG)))
