"""Small raw surveys, with which tests and fuzzers start."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from tests.python.mapping.kmall_file import kmall


def survey(suffix: str, depth_m: float = 2.0) -> bytes:
    """Return a small raw survey: two swaths of five beams. depth_m: of the vehicle, 0.1 m above the transducer."""
    if suffix == ".kmall":
        return kmall()
    from uwsim.mapping.files.swath import EPOCH_NS, SoundSpeeds, SurveyHead, Swath, survey_format

    angles = np.linspace(-0.9, 0.9, 5)
    axes = np.column_stack([0 * angles, -np.sin(angles), np.cos(angles)])
    some, unknown = np.full(5, 0.02), np.full(5, np.nan)
    levels = SoundSpeeds(np.array([0.0, 20.0]), np.array([1500.0, 1490.0]))
    head = SurveyHead("rov", "small", 4e5, 5, 50.0, np.zeros(3), np.zeros(3), levels, "made for tests")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"survey{suffix}"
        write = survey_format(path, "--raw").write
        assert write is not None
        writer = write(path, head)
        for number in range(2):
            time_s = 20.0 / 1500.0 / axes[:, 2]
            writer.add(Swath(
                EPOCH_NS + number * 10**8, 43.1, 5.9, depth_m, 1.0, 0.01, -0.02, 1.0, 0.5, 1498.0,
                np.array([0.2, 0.0, 0.1]),
                time_s, axes, 750.0 * time_s[:, None] * axes + [0.2, 0.0, depth_m + 0.1], angles, -60.0 + 0 * angles,
                some, some, unknown, np.zeros(5, bool),
            ))  # fmt: skip
        writer.close()
        return path.read_bytes()


def xtf_soundings(*kinds: int) -> bytes:
    """Return a small XTF file: a ping of beams by angle, one of processed soundings, and vendors' of some kinds."""
    import pyxtf

    header = pyxtf.XTFFileHeader()
    header.NavUnits, header.NumberOfBathymetryChannels = 3, 1
    header.ChanInfo[0].TypeOfChannel, header.ChanInfo[0].OffsetRoll = 3, 2.0
    beams = [pyxtf.XTFQPSMBEEntry(Id=k, TwoWayTravelTime=0.02, BeamAngle=30.0 * k - 30.0) for k in range(3)]
    soundings = [pyxtf.XTFBeamXYZA(dPosOffsetTrX=1.0, dPosOffsetTrY=k, fDepth=9.0, dTime=0.01) for k in range(3)]
    records = [header.to_bytes()]
    for number, (kind, content) in enumerate([(28, beams), (17, soundings), *((kind, [b"raw"]) for kind in kinds)]):
        ping = pyxtf.XTFPingHeader()
        ping.HeaderType, ping.NumChansToFollow, ping.PingNumber = kind, len(content), number
        ping.Year, ping.Month, ping.Day, ping.Second = 2024, 5, 17, number
        ping.SensorYcoordinate, ping.SensorXcoordinate, ping.SensorDepth = 43.1, 5.9, 2.0
        ping.SoundVelocity, ping.SensorHeading, ping.SensorPitch, ping.SensorRoll = 740.0, 90.0, 3.0, 4.0
        data = b"".join(bytes(each) for each in content)
        ping.NumBytesThisRecord = len(bytes(ping)) + len(data)
        records.append(bytes(ping) + data)
    return b"".join(records)


def side_scan() -> bytes:
    """Return a small side-scan survey: two lines of eight samples to a side."""
    from uwsim.mapping.files.side_scan_line import SideScanHead, SideScanLine
    from uwsim.mapping.files.swath import EPOCH_NS
    from uwsim.mapping.files.xtf import XtfWriter

    head = SideScanHead("rov", "small", 4e5, 50.0, 8, 0.01, 0.7, 0.4, np.zeros(3), "made for tests")
    levels = np.linspace(80.0, 120.0, 8).astype(np.float32)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "survey.xtf"
        writer = XtfWriter(path, head)
        for number in range(2):
            place = (43.1, 5.9)
            writer.add(SideScanLine(
                EPOCH_NS + number * 10**9, place, place, 2.0, 6.0, 1.0, 0.01, -0.02, 0.5, 1498.0, levels, levels[::-1]
            ))  # fmt: skip
        writer.close()
        return path.read_bytes()
