"""The eXtended Triton Format (XTF), by pyxtf: side-scan surveys as processing software reads them.

A sample is the amplitude of the pressure in uPa, a 4-byte float, so that a level is 20 log10 of it. As the format has
it, port samples begin with the farthest, and starboard samples with the nearest. Times are in whole hundredths of a
second. The readers are in xtf_read.py and xtf_multibeam.py.
"""

from __future__ import annotations

import ctypes
import math
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pyxtf

from uwsim.base.atomic_file import GrowingFile
from uwsim.mapping.files.side_scan_line import Levels, SideScanHead, SideScanLine
from uwsim.mapping.files.swath import SurveyFormat
from uwsim.mapping.files.xtf_multibeam import read_xtf_multibeam
from uwsim.mapping.files.xtf_read import read_xtf

KNOT_M_S = 1852.0 / 3600.0
DEGREES_OF_LATITUDE = 3
IEEE_FLOAT = 5
BLOCK = 64  # records are padded to multiples


class XtfWriter:
    """Writes a survey; see SideScanWriter."""

    def __init__(self, path: Path, head: SideScanHead) -> None:
        self._head, self._file = head, GrowingFile(path)
        self._last_ns: int | None = None
        self._number = 0
        self._file.write(_file_header(head, path).to_bytes())

    def add(self, line: SideScanLine) -> None:
        """Append a line."""
        ping = self._ping(line)
        ping.data = [_pressures(line.port_db)[::-1], _pressures(line.starboard_db)]
        ping.ping_chan_headers = [self._channel(line, k) for k in range(2)]
        size = sum(map(ctypes.sizeof, (ping, *ping.ping_chan_headers))) + sum(each.nbytes for each in ping.data)
        padding = -size % BLOCK
        ping.NumBytesThisRecord = size + padding
        content = [bytes(ping)]
        for header, samples in zip(ping.ping_chan_headers, ping.data, strict=True):
            content += [bytes(header), samples.tobytes()]
        self._file.write(b"".join(content) + bytes(padding))
        self._last_ns = line.time_ns
        self._number += 1

    def close(self) -> None:
        """Complete the file."""
        self._file.close()

    def discard(self) -> None:
        """Remove what was written."""
        self._file.discard()

    def _ping(self, line: SideScanLine) -> pyxtf.XTFPingHeader:
        at = datetime.fromtimestamp(line.time_ns // 10**9, UTC)
        ping = pyxtf.XTFPingHeader()
        ping.HeaderType, ping.NumChansToFollow = pyxtf.XTFHeaderType.sonar.value, 2
        ping.Year, ping.Month, ping.Day = at.year, at.month, at.day
        ping.Hour, ping.Minute, ping.Second = at.hour, at.minute, at.second
        ping.HSeconds = line.time_ns % 10**9 // 10**7
        ping.FixTimeHour, ping.FixTimeMinute, ping.FixTimeSecond = at.hour, at.minute, at.second
        ping.FixTimeHsecond = ping.HSeconds
        ping.JulianDay = at.timetuple().tm_yday
        ping.PingNumber = self._number
        ping.SoundVelocity = ping.ComputedSoundVelocity = line.sound_speed_m_s
        ping.ShipSpeed = ping.SensorSpeed = line.speed_m_s / KNOT_M_S
        ping.ShipGyro = ping.SensorHeading = math.degrees(line.heading_rad) % 360.0
        ping.ShipYcoordinate, ping.ShipXcoordinate = line.vehicle_deg
        ping.SensorYcoordinate, ping.SensorXcoordinate = line.sonar_deg
        ping.SensorDepth = line.sonar_depth_m
        ping.SensorPrimaryAltitude = line.altitude_m if math.isfinite(line.altitude_m) else 0.0
        ping.SensorPitch, ping.SensorRoll = math.degrees(line.pitch_rad), math.degrees(line.roll_rad)
        return ping

    def _channel(self, line: SideScanLine, number: int) -> pyxtf.XTFPingChanHeader:
        channel = pyxtf.XTFPingChanHeader()
        channel.ChannelNumber, channel.NumSamples = number, self._head.bins
        channel.SlantRange = self._head.range_max_m
        channel.TimeDuration = 2.0 * self._head.range_max_m / line.sound_speed_m_s
        channel.SecondsPerPing = 0.0 if self._last_ns is None else 1e-9 * (line.time_ns - self._last_ns)
        channel.Frequency = min(round(self._head.frequency_hz / 1000.0), 65535)
        return channel


def _file_header(head: SideScanHead, path: Path) -> pyxtf.XTFFileHeader:
    header = pyxtf.XTFFileHeader()
    header.RecordingProgramName, header.RecordingProgramVersion = b"uwsim", b"1"
    header.SonarName = head.sonar.encode("ascii", "replace")[:15]
    header.NoteString = head.comment.encode("ascii", "replace")[:63]
    header.ThisFileName = path.name.encode("ascii", "replace")[:63]
    header.NavUnits, header.NumberOfSonarChannels = DEGREES_OF_LATITUDE, 2
    sides = ((pyxtf.XTFChannelType.port, b"port"), (pyxtf.XTFChannelType.stbd, b"starboard"))
    for number, (side, name) in enumerate(sides):
        channel = header.ChanInfo[number]
        channel.TypeOfChannel, channel.SubChannelNumber, channel.ChannelName = side.value, number, name
        channel.UniPolar, channel.BytesPerSample, channel.SampleFormat = 1, 4, IEEE_FLOAT
        channel.Reserved, channel.Frequency = head.bins, head.frequency_hz / 1000.0
        channel.HorizBeamAngle = math.degrees(head.along_width_rad)
        channel.BeamWidth, channel.TiltAngle = math.degrees(head.vertical_width_rad), math.degrees(head.depression_rad)
        channel.OffsetY, channel.OffsetX, channel.OffsetZ = head.offset_m.tolist()
    return header


def _pressures(levels_db: Levels) -> Levels:
    return np.power(10.0, 0.05 * levels_db.astype(np.float64)).astype("<f4")


XTF = SurveyFormat(
    "lines of a side-scan sonar, or soundings, in the eXtended Triton Format", side_scan=XtfWriter,
    read_side_scan=read_xtf, read=read_xtf_multibeam,
)  # fmt: skip
