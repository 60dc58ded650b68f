"""Compares two-way times traced through the sound-speed profiles of two EM 302 surveys with the recorded times.

NOAA Ship Okeanos Explorer, 2018 and 2016.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, at_most
from uwsim.evidence.validate.reality.kinds import PREDICTED
from uwsim.mapping.files.gsf_read import read_gsf
from uwsim.mapping.files.swath import Swath
from uwsim.scenario.spec.link import BOTTOMS

SURVEYS = {  # robust standard deviation of two-way times after one rigid offset per ping [s]
    "0059_20181102_212138_EX1811_MB_EM302.gsf": 0.20e-3,
    "0029_20160323_185603_EX1604_EM302.gsf": 0.35e-3,
}
TRANSDUCER_M = 4.3
EVERY = 13  # beams
PROFILE_WITHIN_M_S = 0.02
FILE = f"gsf/{next(iter(SURVEYS))}"


def checks(data: Path) -> list[Check]:
    """Return the checks."""
    found = []
    for name, limit_s in SURVEYS.items():
        if (path := data / "gsf" / name).is_file():
            found.append(survey_check(path, limit_s))
        else:
            warnings.warn(f"validate reality: no {path}", stacklevel=2)
    return found


def survey_check(path: Path, limit_s: float) -> Check:
    """Check the two-way times of a survey, of every 13th beam, after one rigid offset per ping, vertical and across.

    The ship's lever arm and draught explain these offsets.
    """
    head, swaths = read_gsf(path)
    levels = np.column_stack([head.profile.depths_m, head.profile.speeds_m_s])
    thin = thinned(levels[levels[:, 0] < 12_000.0], PROFILE_WITHIN_M_S)
    profile = _core.SoundSpeedProfile(thin[:, 0], thin[:, 1])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a file without the transducer's depth is one whose offset is fitted
        left_s = np.concatenate([_left_s(profile, swath, k % EVERY) for k, swath in enumerate(swaths)])
    spread_s = 1.4826 * float(np.median(np.abs(left_s - np.median(left_s))))
    name = f"{path.stem}: robust sd of {len(left_s)} two-way times"
    return at_most(f"{PREDICTED}: EM 302", name, 1e3 * limit_s, 1e3 * spread_s, "ms")


def _left_s(profile: _core.SoundSpeedProfile, swath: Swath, first: int) -> Floats:
    """Return the residual time differences of some of a ping's beams after fitting the two offsets."""
    rows, left = [], []
    seen = np.column_stack([swath.travel_time_s, swath.sounding_m])[np.isfinite(swath.travel_time_s)]
    for time_s, along_m, across_m, depth_m in seen[first::EVERY].tolist():
        far_m = math.hypot(across_m, along_m)
        found = _core.arrivals(
            profile, TRANSDUCER_M, depth_m, far_m, math.inf, 30e3, BOTTOMS["silt"], within_db=1e9, most_bounces=0
        )
        if not found:
            continue
        ray = found[0]
        speed = profile.at(depth_m)
        dip = ray.arrival_dip_rad
        rows.append([2 * math.sin(dip) / speed, 2 * math.cos(dip) / speed * across_m / max(far_m, 1e-6)])
        left.append(time_s - 2 * ray.time_s)
    slopes, difference = np.array(rows), np.array(left)
    kept = np.ones(len(left), bool)
    for _ in range(5):  # least squares without outliers
        offsets = np.linalg.lstsq(slopes[kept], difference[kept], rcond=None)[0]
        rest: Floats = difference - slopes @ offsets
        kept = np.abs(rest) < 3 * 1.4826 * np.median(np.abs(rest)) + 1e-9
    return rest


def thinned(levels: Floats, within_m_s: float) -> Floats:
    """Return a profile thinned to few levels, linear between them within a tolerance (Douglas and Peucker 1973)."""

    def kept(first: int, last: int) -> Iterator[int]:
        chord = np.interp(levels[first : last + 1, 0], levels[[first, last], 0], levels[[first, last], 1])
        error = np.abs(levels[first : last + 1, 1] - chord)
        worst = int(np.argmax(error))
        if error[worst] <= within_m_s:
            yield last
        else:
            yield from kept(first, first + worst)
            yield from kept(first + worst, last)

    return levels[[0, *kept(0, len(levels) - 1)]]
