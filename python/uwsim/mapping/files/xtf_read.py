"""Reads side scan from the eXtended Triton Format (XTF): our own files, and those of survey software.

Layouts are pyxtf's; a record is decoded here, so that damage is refused at its offset. Each ping with a port and a
starboard channel is a line: of several pairs, the first (most sounders list the lowest frequency first). Other records
are passed over; xtf_multibeam.py reads soundings.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyxtf
from numpy.typing import NDArray

from uwsim.base.texts.text_file import require_regular
from uwsim.mapping.files.side_scan_line import Levels, SideScanHead, SideScanLine

MAGIC, SIDE_SCAN_PING, FORMAT = 0xFACE, 0, 123
PORT, STARBOARD, DEGREES = 1, 2, 3
CHANNELS_OF_FIRST_BLOCK, CHANNELS_OF_BLOCK, BLOCK = 6, 8, 1024
MOST_BYTES = 1 << 24
"""Longest record: 2 channels of a million 8-byte samples; what claims more is refused before it is read."""
SAMPLES = {2: "<u4", 3: "<u2", 5: "<f4", 8: "u1"}
"""Types by ChanInfo.SampleFormat (XTF X41). IBM floats (1) are not read."""
UNSTATED = {1: "u1", 2: "<u2", 4: "<u4"}
"""Types by bytes per sample, of files before SampleFormat existed."""
KNOT_M_S = 1852.0 / 3600.0


def read_xtf(path: Path) -> tuple[SideScanHead, Iterator[SideScanLine]]:
    """Return the head and the lines of a file. Raises OSError, or ValueError with the offset and the rule.

    Levels are 20 log10 of a sample, re 1 uPa in our own files, and re 1 count in others. What a file does not state is
    nan. Raises ValueError also for a file without a ping to both sides.
    """
    file = XtfFile(path)
    with require_regular(path).open("rb") as stream:
        header = file.header(stream)
        first = next(file.pings(stream, header), None)
    if first is None:
        raise ValueError(f"'{path}': at byte 0: must hold side scan to port and starboard, has none")
    line, channel, info = first
    head = SideScanHead(
        vehicle="", sonar=header.SonarName.decode("ascii", "replace"),
        frequency_hz=1000.0 * (float(info.Frequency) or float(channel.Frequency)),
        range_max_m=float(channel.SlantRange), bins=len(line.port_db),
        along_width_rad=math.radians(info.HorizBeamAngle), vertical_width_rad=math.radians(info.BeamWidth),
        depression_rad=math.radians(info.TiltAngle),
        offset_m=np.array([info.OffsetY, info.OffsetX, info.OffsetZ], np.float64),
        comment=header.NoteString.decode("ascii", "replace"),
    )  # fmt: skip
    return head, file.lines(head)


class XtfFile:
    """One file, whose name and offset all errors state."""

    def __init__(self, path: Path) -> None:
        self._path, self._size = path, path.stat().st_size

    def refused(self, at: int, rule: str) -> ValueError:
        """Return the error for a rule that is broken at an offset."""
        return ValueError(f"'{self._path}': at byte {at}: {rule}")

    def header(self, stream: BinaryIO) -> Any:
        """Return the file's header, with `channels`, the descriptions of all side-scan channels."""
        data = stream.read(BLOCK)
        if len(data) < BLOCK or data[0] != FORMAT:
            raise self.refused(0, f"not XTF: must begin with a header of {BLOCK} bytes whose first is {FORMAT}")
        header = pyxtf.XTFFileHeader.from_buffer_copy(data)
        sides = header.NumberOfSonarChannels
        every = sides + sum(
            int(getattr(header, f"NumberOf{kind}"))
            for kind in ("BathymetryChannels", "SnippetChannels", "EchoStrengthChannels", "InterferometryChannels")
        ) + header.NumberOfForwardLookArrays  # fmt: skip
        more = -(-max(0, every - CHANNELS_OF_FIRST_BLOCK) // CHANNELS_OF_BLOCK)
        further = stream.read(more * BLOCK)
        if len(further) < more * BLOCK:
            raise self.refused(BLOCK, f"the file ends within the descriptions of its {every} channels")
        size = ctypes.sizeof(pyxtf.XTFChanInfo)
        channels = list(header.ChanInfo) + [
            pyxtf.XTFChanInfo.from_buffer_copy(further, block * BLOCK + k * size)
            for block in range(more)
            for k in range(CHANNELS_OF_BLOCK)
        ]
        header.channels, header.every_channel = channels[:sides], channels[:every]
        return header

    def pings(self, stream: BinaryIO, header: Any) -> Iterator[tuple[SideScanLine, Any, Any]]:
        """Yield each ping to both sides with its port channel and that channel's description, from here on."""
        for at, kind, data in self.records(stream):
            if kind == SIDE_SCAN_PING and (found := self._ping(at, data, header)) is not None:
                yield found

    def records(self, stream: BinaryIO) -> Iterator[tuple[int, int, bytes]]:
        """Yield the offset, the type and the bytes of each record, from here on."""
        while start := stream.read(ctypes.sizeof(pyxtf.XTFPacketStart)):
            at = stream.tell() - len(start)
            if len(start) < ctypes.sizeof(pyxtf.XTFPacketStart):
                raise self.refused(at, "the file ends within the start of a record")
            packet = pyxtf.XTFPacketStart.from_buffer_copy(start)
            size = int(packet.NumBytesThisRecord)
            if packet.MagicNumber != MAGIC:
                raise self.refused(at, "not a record of XTF: must begin with 0xFACE")
            if not len(start) <= size <= MOST_BYTES:
                raise self.refused(at, f"a record of {size} bytes: must have {len(start)} to {MOST_BYTES}")
            if at + size > self._size:
                raise self.refused(at, f"the file ends within a record of {size} bytes")
            yield at, int(packet.HeaderType), start + stream.read(size - len(start))

    def lines(self, head: SideScanHead) -> Iterator[SideScanLine]:
        """Yield the lines of the file, with the first one's range and number of samples."""
        with self._path.open("rb") as stream:
            for line, channel, _ in self.pings(stream, self.header(stream)):
                reach_m, bins = float(channel.SlantRange), len(line.port_db)
                if (reach_m, bins) == (head.range_max_m, head.bins):
                    yield line
                    continue
                ratio = head.range_max_m / reach_m * (bins / head.bins)
                kept = np.floor((np.arange(head.bins) + 0.5) * ratio).astype(int)
                port, starboard = (
                    np.where(kept < bins, side[np.minimum(kept, bins - 1)], np.float32(np.nan)).astype(np.float32)
                    for side in (line.port_db, line.starboard_db)
                )
                yield SideScanLine(**{**vars(line), "port_db": port, "starboard_db": starboard})

    def _ping(self, at: int, data: bytes, header: Any) -> tuple[SideScanLine, Any, Any] | None:
        """Return a ping; None if it has no pair of sides."""
        ping, place = pyxtf.XTFPingHeader, ctypes.sizeof(pyxtf.XTFPingHeader)
        if len(data) < place:
            raise self.refused(at, f"a ping of {len(data)} bytes: must have at least {place}")
        stated = ping.from_buffer_copy(data)
        sides: dict[int, tuple[Any, Any, NDArray[Any]]] = {}
        for number in range(stated.NumChansToFollow):
            if place + ctypes.sizeof(pyxtf.XTFPingChanHeader) > len(data):
                raise self.refused(at, f"its ping ends before channel {number} of {stated.NumChansToFollow}")
            channel = pyxtf.XTFPingChanHeader.from_buffer_copy(data, place)
            place += ctypes.sizeof(pyxtf.XTFPingChanHeader)
            if channel.ChannelNumber >= len(header.channels):
                raise self.refused(
                    at,
                    f"channel {channel.ChannelNumber}: must be below {len(header.channels)}, the number in its header",
                )
            info = header.channels[channel.ChannelNumber]
            samples, place = self._samples(at, data, place, channel, info)
            sides.setdefault(int(info.TypeOfChannel), (channel, info, samples))
        if PORT not in sides or STARBOARD not in sides:
            return None
        (channel, info, port), (other, _, starboard) = sides[PORT], sides[STARBOARD]
        if len(port) != len(starboard) or channel.SlantRange != other.SlantRange:
            raise self.refused(at, "its sides must have the same range and number of samples")
        if not (math.isfinite(channel.SlantRange) and 0.01 <= channel.SlantRange <= 1e5):
            raise self.refused(at, f"slant range {channel.SlantRange:g} m: must be in [0.01, 100000] m")
        return self._line(at, stated, header, port[::-1], starboard), channel, info

    def _samples(self, at: int, data: bytes, place: int, channel: Any, info: Any) -> tuple[NDArray[Any], int]:
        count = int(channel.NumSamples) or int(info.Reserved)
        kind = SAMPLES.get(info.SampleFormat) or (UNSTATED.get(info.BytesPerSample) if not info.SampleFormat else None)
        if kind is None:
            raise self.refused(
                at, f"samples of format {info.SampleFormat} and {info.BytesPerSample} bytes: must be one of "
                f"{', '.join(map(str, SAMPLES))}, or have 1, 2 or 4 bytes"
            )  # fmt: skip
        end = place + count * np.dtype(kind).itemsize
        if count == 0 or end > len(data):
            raise self.refused(at, f"a channel of {count} samples: must have one or more, within its record")
        return np.frombuffer(data, kind, count, place), end

    def time_ns(self, at: int, ping: Any) -> int:
        """Return the time of a ping since 1970."""
        try:
            day = datetime(ping.Year, ping.Month, ping.Day, ping.Hour, ping.Minute, min(ping.Second, 59), tzinfo=UTC)
        except ValueError as error:
            raise self.refused(at, f"its time: {error}") from None
        return (day - datetime(1970, 1, 1, tzinfo=UTC)) // timedelta(seconds=1) * 10**9 + int(ping.HSeconds) * 10**7

    def _line(self, at: int, ping: Any, header: Any, port: NDArray[Any], starboard: NDArray[Any]) -> SideScanLine:
        angles = ping.SensorHeading, ping.SensorPitch, ping.SensorRoll
        heading, pitch, roll = (math.radians(_finite(each)) for each in angles)
        is_placed = header.NavUnits == DEGREES
        altitude_m = _finite(ping.SensorPrimaryAltitude)
        return SideScanLine(
            time_ns=self.time_ns(at, ping),
            vehicle_deg=(ping.ShipYcoordinate, ping.ShipXcoordinate) if is_placed else (math.nan, math.nan),
            sonar_deg=(ping.SensorYcoordinate, ping.SensorXcoordinate) if is_placed else (math.nan, math.nan),
            sonar_depth_m=_finite(ping.SensorDepth), altitude_m=altitude_m if altitude_m > 0.0 else math.nan,
            heading_rad=heading % math.tau, pitch_rad=pitch, roll_rad=roll,
            speed_m_s=_finite(ping.SensorSpeed) * KNOT_M_S,
            sound_speed_m_s=_finite(ping.SoundVelocity), port_db=_levels(port), starboard_db=_levels(starboard),
        )  # fmt: skip


def _finite(value: float) -> float:
    return float(value) if math.isfinite(value) else math.nan


def _levels(samples: NDArray[Any]) -> Levels:
    """Return 20 log10 of the samples; nan for those that are zero or no number."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        level = 20.0 * np.log10(np.abs(samples.astype(np.float64)))
    return np.where(np.isfinite(level), level, np.nan).astype(np.float32)
