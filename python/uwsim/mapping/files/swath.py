"""The content of a survey file: the head of a survey, and its swaths with travel times, as surveyors' formats have it.

Every format is one file, registered in `uwsim.kinds.survey_file`; its writer takes these, and its reader returns them.
Axes of a level vehicle: forward, starboard, down, from the vehicle's reference point, with the heading from true north.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats as Floats
from uwsim.base.sockets import load
from uwsim.base.texts.text_file import first_bytes

if TYPE_CHECKING:
    from uwsim.mapping.files.side_scan_line import SideScanHead, SideScanLine, SideScanWriter

GROUP = "uwsim.kinds.survey_file"
EPOCH_NS = 1_577_836_800_000_000_000
"""2020-01-01T00:00:00Z, the time of day at which each simulated world begins: the same run writes the same file."""


@dataclass(frozen=True, eq=False)
class SoundSpeeds:
    """A profile of the speed of sound. depths_m (n,), below the water surface, increasing; speeds_m_s (n,)."""

    depths_m: Floats
    speeds_m_s: Floats


@dataclass(frozen=True, eq=False)
class SurveyHead:
    """Values that hold for a whole survey.

    sonar: name of the echo sounder. offset_m (3,): the transducer from the vehicle's reference point, and mount_rad
    (3,): its roll, pitch and heading, both in the vehicle's axes. comment: one line about the source.
    """

    vehicle: str
    sonar: str
    frequency_hz: float
    beams: int
    max_range_m: float
    offset_m: Floats
    mount_rad: Floats
    profile: SoundSpeeds
    comment: str


@dataclass(frozen=True, eq=False)
class Swath:
    """One ping. All angles in rad, depths below the water surface.

    time_ns: since 1970, UTC. heading_rad: from true north, clockwise; pitch_rad: bow up; roll_rad: starboard down.
    reference_depth_m: depth of the vehicle's reference point, which is at the latitude and longitude. transducer_m
    (3,): its place, level axes. travel_time_s (n,): two-way; nan without detection. axes (n, 3): unit vectors at
    transmission, level axes. sounding_m (n, 3): level axes, with the depth below the water surface; nan without
    detection. beam_rad (n,): about the head's own forward axis, positive to port. amplitude_db, deviation_m (vertical,
    horizontal; nan if unknown), is_phase, quality (n,): the detector's own; quality is a standard deviation of the
    range as a share of the range, nan if unknown.
    """

    time_ns: int
    latitude_deg: float
    longitude_deg: float
    reference_depth_m: float
    heading_rad: float
    pitch_rad: float
    roll_rad: float
    course_rad: float
    speed_m_s: float
    sound_speed_m_s: float
    transducer_m: Floats
    travel_time_s: Floats
    axes: Floats
    sounding_m: Floats
    beam_rad: Floats
    amplitude_db: Floats
    vertical_deviation_m: Floats
    horizontal_deviation_m: Floats
    quality: Floats
    is_phase: NDArray[np.bool_]

    @property
    def is_detected(self) -> NDArray[np.bool_]:
        """True for each beam with a travel time, (n,)."""
        return np.isfinite(self.travel_time_s)


class SwathWriter(Protocol):
    """Writes one file: nothing is there under its name before `close`."""

    def add(self, swath: Swath) -> None:
        """Append a swath. Raises OSError, or ValueError for a value that the format cannot hold."""

    def close(self) -> None:
        """Complete the file. Raises OSError."""

    def discard(self) -> None:
        """Remove what was written."""


@dataclass(frozen=True)
class SurveyFormat:
    """A format of raw surveys.

    content: what a file holds. write(path, head): returns a writer; None if the format is only read. read(path):
    returns the head and the swaths in the order of the file; raises OSError, or ValueError with the file's name, the
    offset and the rule; None if the format is only written. side_scan(path, head): returns a writer of side scan, if
    the format holds that instead; read_side_scan(path): its head and lines, with the errors of read.
    """

    content: str
    write: Callable[[Path, SurveyHead], SwathWriter] | None = None
    read: Callable[[Path], tuple[SurveyHead, Iterator[Swath]]] | None = None
    side_scan: Callable[[Path, SideScanHead], SideScanWriter] | None = None
    read_side_scan: Callable[[Path], tuple[SideScanHead, Iterator[SideScanLine]]] | None = None


MARKS: Mapping[str, Callable[[bytes], bool]] = {
    "gsf": lambda head: head[8:12] == b"GSF-",
    "kmall": lambda head: re.fullmatch(rb"#[A-Z]{3}", head[4:8]) is not None,
    "xtf": lambda head: len(head) >= HEAD and head[0] == 123,
}
"""By format, whether a file's first bytes are its own."""
HEAD = 1024


def format_of(path: Path) -> str | None:
    """Return the name of a survey file's format, by its suffix, else by its first bytes; None if it is no survey.

    Archives and MB-System name a file with the format in another place, such as line.gsf.mb121.
    """
    from uwsim.base.sockets import registered

    name = path.suffix.lower().removeprefix(".")
    if name in registered(GROUP):
        return name
    try:
        head = first_bytes(path, HEAD)
    except OSError:
        return None
    return next((each for each, marks in MARKS.items() if marks(head)), None)


def survey_of(path: Path, option: str) -> SurveyFormat:
    """Return the format of a file to read. Raises ValueError, which names the option, for one of no known format."""
    name = format_of(path)
    return survey_format(path if name is None else path.with_suffix(f".{name}"), option)


def survey_format(path: Path, option: str) -> SurveyFormat:
    """Return the format of a path by its suffix. Raises ValueError, which names the option, for an unknown one."""
    from uwsim.base.sockets import registered

    suffixes = [f".{name}" for name in registered(GROUP)]
    if path.suffix.lower() not in suffixes:
        raise ValueError(f"{option} {path}: must end in {' or '.join(suffixes)}")
    found: SurveyFormat = load(GROUP, path.suffix.lower().removeprefix("."), _fitting)
    return found


def _fitting(name: str, found: object) -> SurveyFormat:
    if not isinstance(found, SurveyFormat):
        raise TypeError(f"must be a {SurveyFormat.__module__}.{SurveyFormat.__name__}")
    return found
