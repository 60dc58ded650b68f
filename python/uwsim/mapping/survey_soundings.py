"""The soundings of survey files, real or simulated, traced from their travel times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping.files.georeference import Georeference, metres_about
from uwsim.mapping.files.swath import Swath, survey_of
from uwsim.mapping.ping_to_map import traced_beams


@dataclass(frozen=True, eq=False)
class SurveySource:
    """A survey file: its sound-speed profile, its first swath, and all of its swaths, which can be read once."""

    profile: _core.SoundSpeedProfile
    first: Swath
    swaths: Iterator[Swath]


@dataclass(frozen=True, eq=False)
class Soundings:
    """points_m (n, 3), in metres east and north of a place and up from the mean surface.

    deviation_m (n,): vertical standard deviations as the files state them, nan where they state none.
    """

    points_m: NDArray[np.float64]
    deviation_m: NDArray[np.float64]
    place: Georeference


def open_surveys(paths: Sequence[Path], option: str) -> list[SurveySource]:
    """Open survey files. Raises OSError, or ValueError that names the file, for one without pings of a multibeam."""
    surveys = []
    for path in paths:
        read = survey_of(path, option).read
        if read is None:
            raise ValueError(f"{option} {path}: holds no pings of a multibeam")
        head, swaths = read(path)
        first = list(islice(swaths, 1))
        if not first:
            raise ValueError(f"{option} {path}: has no ping")
        profile = _core.SoundSpeedProfile(head.profile.depths_m, head.profile.speeds_m_s)
        surveys.append(SurveySource(profile, first[0], chain(first, swaths)))
    return surveys


def read_soundings(path: Path, option: str, place: Georeference | None = None) -> Soundings:
    """Return the soundings of a file that it does not flag, by default about the place of its first ping.

    Raises OSError or ValueError.
    """
    (survey,) = open_surveys([path], option)
    if place is None:
        place = Georeference(metres_about((survey.first.longitude_deg, survey.first.latitude_deg)))
    points, deviations = [np.empty((0, 3))], [np.empty(0)]
    for swath in survey.swaths:
        ends, _ = traced_beams(swath, survey.profile, place)
        seen = np.isfinite(ends[:, 0])
        points.append(ends[seen])
        deviations.append(swath.vertical_deviation_m[seen])
    return Soundings(np.concatenate(points), np.concatenate(deviations), place)
