"""Generic Sensor Format (GSF) 3.11, by gsfu: surveys of multibeam echo sounders as processing software reads them.

Angles of a beam follow gsf.h: the angle from the vertical, and the azimuth counterclockwise from starboard, both of the
level vehicle; errors are at 95 % confidence, 1.96 and 2.45 standard deviations. The reader is in gsf_read.py.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from GSFU import gsfu

from uwsim.base.atomic_file import GrowingFile
from uwsim.mapping.files.gsf_read import DETECTION_PHASE, ERRORS, KNOT_M_S, read_gsf
from uwsim.mapping.files.swath import SurveyFormat, SurveyHead, Swath

EM2040, KMALL_SPECIFIC = 2040, 156
IGNORED = 0x01  # a beam flag: rejected
DETECTION_AMPLITUDE, NOT_DETECTED = 1, 0
FINE = {
    "Depth_m": (1e4, 0.0, 4, False),
    "AcrossTrack_m": (1e4, 0.0, 4, True),
    "AlongTrack_m": (1e4, 0.0, 4, True),
    "TravelTime_s": (1e8, 0.0, 4, False),
    "BeamAngle_deg": (180.0, 0.0, 2, True),
    "BeamAngleForward_deg": (180.0, 0.0, 2, False),
}
"""Multiplier, offset, bytes and sign of the beams' arrays: 0.1 mm, 10 ns, 0.006 deg. Others are as gsfu has them."""


class GsfWriter:
    """Writes a survey; see SwathWriter."""

    def __init__(self, path: Path, head: SurveyHead) -> None:
        self._head, self._file, self._is_first = head, GrowingFile(path), True
        self._gsf = gsfu.gsf(str(path))
        self._gsf.FID = self._file
        self._gsf.write_header()
        self._scales = gsfu.DEFAULT_PING_SCALE_FACTORS | {
            gsfu.BEAM_ARRAY_SUBRECORD_IDS[name]: scale for name, scale in FINE.items()
        }
        self._number = 0

    def add(self, swath: Swath) -> None:
        """Append a swath and its attitude."""
        at = datetime.fromtimestamp(swath.time_ns * 1e-9, UTC)
        if self._is_first:
            self._is_first = False
            self._begin(at, swath)
        degrees = np.degrees([swath.pitch_rad, swath.roll_rad, swath.heading_rad % math.tau])
        heading_deg = degrees[2] % 359.995  # 360.00 is not a heading
        self._gsf.write_attitude({
            "Time": np.array([swath.time_ns], "datetime64[ns]"), "Pitch_deg": degrees[:1], "Roll_deg": degrees[1:2],
            "Heave_m": np.zeros(1), "Heading_deg": np.array([heading_deg]),
        })  # fmt: skip
        ping = gsfu.new_swath_bathymetry_ping() | {
            "PingTime": at, "Longitude_deg": swath.longitude_deg, "Latitude_deg": swath.latitude_deg,
            "NumberBeams": len(swath.travel_time_s), "CenterBeam": len(swath.travel_time_s) // 2,
            "TideCorrector_m": 0.0,
            "DepthCorrector_m": swath.reference_depth_m + float(swath.transducer_m[2]), "Heading_deg": heading_deg,
            "Pitch_deg": degrees[0], "Roll_deg": degrees[1], "Heave_m": 0.0,
            "Course_deg": math.degrees(swath.course_rad) % 359.995, "Speed_kn": swath.speed_m_s / KNOT_M_S,
            "Beams": _beams(swath), "SensorSpecificID": KMALL_SPECIFIC, "SensorSpecific": self._specific(swath),
        }  # fmt: skip
        self._gsf.write_swath_bathymetry_ping(ping, self._scales)
        self._number += 1

    def close(self) -> None:
        """Complete the file."""
        self._file.close()

    def discard(self) -> None:
        """Remove what was written."""
        self._file.discard()

    def _begin(self, at: datetime, swath: Swath) -> None:
        head = self._head
        self._gsf.write_processing_parameters({"ParamTime": at, "Parameters": _parameters(head)})
        self._gsf.write_comment({"CommentTime": at, "Comment": head.comment})
        self._gsf.write_sound_velocity_profile({
            "ObservationTime": at, "ApplicationTime": at, "Longitude_deg": swath.longitude_deg,
            "Latitude_deg": swath.latitude_deg, "Depth_m": head.profile.depths_m,
            "SoundSpeed_mPerSec": head.profile.speeds_m_s,
        })  # fmt: skip

    def _specific(self, swath: Swath) -> dict[str, Any]:
        beams = len(swath.travel_time_s)
        sector = gsfu.new_kmall_tx_sector() | {"CentreFreq_Hz": self._head.frequency_hz}
        specific: dict[str, Any] = gsfu.new_kmall_specific()
        return specific | {
            "DgmType": 1, "DgmVersion": 3, "EchoSounderID": EM2040, "PingCnt": self._number % 65536,
            "RxFansPerPing": 1, "SwathsPerPing": 1, "NumRxTransducers": 1, "FrequencyMode_Hz": self._head.frequency_hz,
            "HeadingVessel_deg": math.degrees(swath.heading_rad) % 360.0,
            "SoundSpeedAtTxDepth_mPerSec": swath.sound_speed_m_s,
            "TxTransducerDepth_m": swath.reference_depth_m + float(swath.transducer_m[2]),
            "Latitude_deg": swath.latitude_deg, "Longitude_deg": swath.longitude_deg, "NumSoundingsMaxMain": beams,
            "NumSoundingsValidMain": int(swath.is_detected.sum()),
            "TxSectors": {name: [value] for name, value in sector.items()},
        }  # fmt: skip


def _beams(swath: Swath) -> dict[str, Any]:
    seen = swath.is_detected
    zero = np.zeros(len(seen))
    along, across, depth = np.where(seen[:, None], swath.sounding_m, 0.0).T
    forward, starboard, down = swath.axes.T
    azimuth_deg = np.degrees(np.arctan2(forward, starboard)) % 360.0
    vertical_m, horizontal_m = (
        np.where(seen & np.isfinite(each), factor * each, 0.0)
        for factor, each in zip(
            ERRORS.values(), (swath.vertical_deviation_m, swath.horizontal_deviation_m), strict=True
        )
    )
    kind = np.where(seen, np.where(swath.is_phase, DETECTION_PHASE, DETECTION_AMPLITUDE), NOT_DETECTED)
    heard = np.where(seen & np.isfinite(swath.amplitude_db), swath.amplitude_db, 0.0)
    return {
        "Depth_m": np.maximum(depth, 0.0), "AcrossTrack_m": across, "AlongTrack_m": along,
        "TravelTime_s": np.where(seen, swath.travel_time_s, 0.0),
        "BeamAngle_deg": np.degrees(np.arccos(np.clip(down, -1.0, 1.0))),
        "BeamAngleForward_deg": np.where(azimuth_deg < 359.997, azimuth_deg, 0.0),
        "MeanCalAmplitude_dB": np.clip(heard, -32_000.0, 32_000.0),
        "QualityFactor": np.where(seen & np.isfinite(swath.quality), np.clip(1e4 * swath.quality, 0.0, 254.0), zero),
        "BeamFlags": np.where(seen, 0, IGNORED).astype(np.uint8), "DetectionInfo": kind,
        "VerticalError_m": np.minimum(vertical_m, 655.0), "HorizontalError_m": np.minimum(horizontal_m, 655.0),
        "SectorNumber": zero,
    }  # fmt: skip


def _parameters(head: SurveyHead) -> dict[str, str]:
    x, y, z = head.offset_m
    roll, pitch, heading = np.degrees(head.mount_rad)
    return {
        "REFERENCE TIME": "1970/001 00:00:00", "PLATFORM_TYPE": "ROV", "FULL_RAW_DATA": "FALSE",
        "ROLL_COMPENSATED": "YES", "PITCH_COMPENSATED": "YES", "HEAVE_COMPENSATED": "YES", "TIDE_COMPENSATED": "NO ",
        "NUMBER_OF_RECEIVERS": "1", "NUMBER_OF_TRANSMITTERS": "1", "DEPTH_CALCULATION": "CORRECTED",
        "RAY_TRACING": "YES", "MSB_APPLIED_TO_ATTITUDE": "YES", "HEAVE_REMOVED_FROM_GPS_TC": "NO",
        "UTC_OFFSET": "+00", "GEOID": "WGS-84", "TIDAL_DATUM": "MSL",
        "APPLIED_POSITION_OFFSET": "+00.00,+00.00,+00.00",
        "APPLIED_TRANSDUCER_OFFSET": f"{x:+.4f},{y:+.4f},{z:+.4f}",
        "APPLIED_TRANSDUCER_PITCH_OFFSET": f"{pitch:+.3f}", "APPLIED_TRANSDUCER_ROLL_OFFSET": f"{roll:+.3f}",
        "APPLIED_TRANSDUCER_HEADING_OFFSET": f"{heading:+.3f}",
        "APPLIED_POSITION_LATENCY": "+0.000", "APPLIED_ATTITUDE_LATENCY": "+0.000",
    }  # fmt: skip


GSF = SurveyFormat("multibeam pings in the Generic Sensor Format", GsfWriter, read_gsf)
