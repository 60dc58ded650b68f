"""Writes PD0, Teledyne RDI's binary ensembles (WorkHorse Commands and Output Data Format, P/N 957-6156-00, ch. 8).

Each ensemble has a fixed and a variable leader, cells of water velocity (one, marked bad, for an instrument without
cells), and the bottom track with the water track of the reference layer. Velocities are those of the bottom or the
water as the instrument sees it, minus its own, in ship axes (starboard, forward, up) without its tilts, in mm/s. Beams
are in RDI's order, 1 opposite 2 and 3 opposite 4: the first of ours, the third, the fourth, the second. Ranges are
vertical, in cm. Fields without a model are zero.
"""

from __future__ import annotations

import math
import struct
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from uwsim.base.atomic_file import GrowingFile
from uwsim.mapping.files.dvl_ensemble import Array, DvlEnsemble, DvlHead, WaterCells
from uwsim.mapping.files.swath import SurveyFormat

FIRMWARE = 9, 14  # of a WorkHorse Navigator, whose layout is written
FREQUENCY_600_KHZ, CONVEX = 3, 8
SLANTS_DEG = (15, 20, 30)
OTHER_SLANT, FOUR_BEAMS = 3, 0x40
SIMULATED = 1
SHIP_AXES = 0b10000
FIXED_LEADER, VARIABLE_LEADER, VELOCITY, BOTTOM_TRACK = 0x0000, 0x0080, 0x0100, 0x0600
BAD = -32768
ORDER = [0, 2, 3, 1]
DECAPASCAL_PA = 10.0
NO_CELLS = WaterCells(1, 1.0, 0.5, (0.0, 0.0))
LOST = np.full(3, math.nan)


class Pd0Writer:
    """Writes ensembles; see DvlWriter."""

    def __init__(self, path: Path, head: DvlHead) -> None:
        self._head, self._file, self._number = head, GrowingFile(path), 0

    def add(self, ensemble: DvlEnsemble) -> None:
        """Append an ensemble."""
        self._number += 1
        parts = [self._fixed(), self._variable(ensemble), self._cells(ensemble), self._bottom(ensemble)]
        start = 6 + 2 * len(parts)
        offsets = start + np.cumsum([0, *(len(part) for part in parts[:-1])])
        size = start + sum(map(len, parts))
        data = struct.pack(f"<2BHBB{len(parts)}H", 0x7F, 0x7F, size + 2, 0, len(parts), *offsets.tolist())
        data += b"".join(parts) + bytes(2)  # reserved
        self._file.write(data + struct.pack("<H", sum(data) & 0xFFFF))

    def close(self) -> None:
        """Complete the file."""
        self._file.close()

    def discard(self) -> None:
        """Remove what was written."""
        self._file.discard()

    def _fixed(self) -> bytes:
        slant_deg = round(math.degrees(self._head.slant_rad), 3)
        code = SLANTS_DEG.index(slant_deg) if slant_deg in SLANTS_DEG else OTHER_SLANT
        about = FREQUENCY_600_KHZ | CONVEX, FOUR_BEAMS | code, SIMULATED, 0
        minutes, hundredths = divmod(min(round(100.0 * self._head.period_s), 255 * 6000), 6000)
        cells, beams, pings, mode = self._head.cells or NO_CELLS, 4, 1, 1
        size_cm, first_cm = _centimetres(cells.size_m), _centimetres(cells.first_m)
        blank_cm = max(0, _centimetres(cells.first_m - 0.5 * cells.size_m))
        return (
            struct.pack("<H8B3HB", FIXED_LEADER, *FIRMWARE, *about, beams, cells.count, pings, size_cm, blank_cm, mode)
            + bytes(3 + 2)  # thresholds
            + bytes([minutes, hundredths // 100, hundredths % 100])
            + bytes([SHIP_AXES])
            + bytes(4 + 2)  # alignments, sources
            + struct.pack("<2H", first_cm, size_cm)
            + bytes(4 + 2 + 10)  # thresholds, lag, serial number, bandwidth
        )

    def _cells(self, ping: DvlEnsemble) -> bytes:
        count = (self._head.cells or NO_CELLS).count
        velocities = np.full((count, 3), math.nan) if ping.cells_m_s is None else ping.cells_m_s
        return struct.pack("<H", VELOCITY) + b"".join(
            struct.pack("<4h", *_as_seen(each, math.nan)) for each in velocities
        )

    def _variable(self, ping: DvlEnsemble) -> bytes:
        at = datetime.fromtimestamp(ping.time_ns // 10**9, UTC)
        clock = (at.year % 100, at.month, at.day, at.hour, at.minute, at.second, ping.time_ns % 10**9 // 10**7)
        number, more = self._number % 65536, self._number // 65536 % 256
        degrees = (math.degrees(each) for each in (ping.heading_rad % math.tau, ping.pitch_rad, ping.roll_rad))
        heading, pitch, roll = (round(100.0 * each) for each in degrees)
        gauge_dapa = round(max(0.0, ping.pressure_pa - 101_325.0) / DECAPASCAL_PA)
        return (
            struct.pack("<HH7BBH", VARIABLE_LEADER, number, *clock, more, 0)
            + struct.pack(
                "<3H2hHh", round(ping.sound_speed_m_s), min(round(10.0 * max(0.0, ping.depth_m)), 9999),
                heading % 36000, pitch, roll, round(ping.salinity_psu), round(100.0 * ping.temperature_deg_c),
            )
            + bytes(6 + 8 + 4 + 2)  # waits, deviations, voltages, status, reserved
            + struct.pack("<IIB", gauge_dapa, 0, 0)
        )  # fmt: skip

    def _bottom(self, ping: DvlEnsemble) -> bytes:
        errors = ping.beam_velocities_m_s[0] + ping.beam_velocities_m_s[2]
        errors -= ping.beam_velocities_m_s[1] + ping.beam_velocities_m_s[3]
        error = errors / (2.0 * math.sqrt(2.0) * math.sin(self._head.slant_rad))
        layer_dm = [min(_centimetres(each) // 10, 9999) for each in (self._head.cells or NO_CELLS).layer_m]
        track = LOST if ping.water_track_m_s is None else ping.water_track_m_s
        track_good = 100 if np.isfinite(track).all() else 0
        vertical_cm = np.round(100.0 * ping.beam_ranges_m[ORDER] * math.cos(self._head.slant_rad))
        seen = np.isfinite(vertical_cm)
        range_cm = np.where(seen, np.clip(vertical_cm, 0, (1 << 24) - 1), 0).astype(int)
        return (
            struct.pack("<HHH4BHI", BOTTOM_TRACK, 1, 0, 0, 0, 0, 0, 0, 0)
            + struct.pack("<4H4h", *(range_cm & 0xFFFF).tolist(), *_as_seen(ping.velocity_m_s, error))
            + bytes([255 if each else 0 for each in seen]) + bytes(4) + bytes([100 if each else 0 for each in seen])
            + struct.pack("<3H4h", layer_dm[1] - layer_dm[0], *layer_dm, *_as_seen(track, math.nan))
            + bytes(8) + bytes([track_good] * 4) + bytes(7) + bytes((range_cm >> 16).tolist())
        )  # fmt: skip


def _as_seen(velocity_m_s: Array, error_m_s: float) -> list[int]:
    """Return the fields of what moves past an instrument that has this velocity, forward, starboard and up."""
    ahead, starboard, up = velocity_m_s
    return [_millimetres(each) for each in (-starboard, -ahead, -up, error_m_s)]


def _centimetres(length_m: float) -> int:
    return min(round(100.0 * length_m), 65_535)


def _millimetres(velocity_m_s: float) -> int:
    """Return a velocity in mm/s; BAD for one that is unknown or beyond the field."""
    if not math.isfinite(velocity_m_s) or abs(velocity_m_s) > 32.767:
        return BAD
    return round(1000.0 * float(velocity_m_s))


PD0 = SurveyFormat("bottom and water track of the DVL in Teledyne RDI's ensembles", dvl=Pd0Writer)
