"""The sound suite: compares arrivals with BELLHOP, times with a recorded survey, backscatter with a published table.

BELLHOP's arrivals are stored beside this file (tests/python/data/README.md has the recipe). The survey, by an EM 302,
is in `gsf/` of the data folder, which is not part of uwsim; without it, its checks are skipped.
"""

from __future__ import annotations

import lzma
import math
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.texts.json_text import json_value
from uwsim.evidence.validate import backscatter
from uwsim.evidence.validate.check import Check, at_most, within
from uwsim.evidence.validate.echo_soundings import Ping, read_soundings
from uwsim.instruments.acoustics import Arrivals, arrivals
from uwsim.scenario.spec.link import BOTTOMS

KEPT = Path(__file__).parent / "bellhop_arrivals.json.xz"
TIME_S, LEVEL_DB = 10e-6, 1.0
SAME = 2e-3  # largest difference between arrivals taken to be the same: time [s] plus launch angle [1000 deg]

SURVEYS = {  # robust standard deviation of two-way times after one rigid offset per ping [s]
    "0059_20181102_212138_EX1811_MB_EM302.gsf": 0.20e-3,
    "0029_20160323_185603_EX1604_EM302.gsf": 0.35e-3,
}
TRANSDUCER_M = 4.3
EVERY = 13  # beams
PROFILE_WITHIN_M_S = 0.02

Floats = NDArray[np.float64]


def run(out: Path | None = None, data: Path | None = None) -> list[Check]:
    """Return the checks of the suite; draw its curves into the folder `out`. data: the folder that contains `gsf/`."""
    checks = bellhop_checks() + backscatter.checks()
    if out is not None:
        backscatter.draw(out / "sound_backscatter.png")
    for name, limit_s in SURVEYS.items():
        path = None if data is None else data / "gsf" / name
        if path is not None and path.is_file():
            checks.append(survey_check(path, limit_s))
        else:
            where = "no folder of data (--data)" if path is None else f"{path}: no such file"
            sys.stderr.write(f"sound: left out: two-way times of {name}: {where}\n")
    return checks


@cache
def kept_cases() -> list[dict[str, Any]]:
    """Return BELLHOP's cases, each with its profile, ends, bottom and arrivals.

    Each arrival is a row: time, level, launch angle [deg], phase [deg], bounces.
    """
    return list(json_value(lzma.decompress(KEPT.read_bytes()), str(KEPT)))


def computed(case: dict[str, Any]) -> Arrivals:
    """Return our arrivals for a case."""
    ends = (case["source_depth_m"], case["receiver_depth_m"], case["range_m"])
    return arrivals(case["profile"], *ends, case["bottom"], within_db=40)


def counterparts(found: Arrivals, case: dict[str, Any]) -> list[int | None]:
    """Return, for each BELLHOP arrival, the index of our nearest arrival in angle and time with the same bounces."""
    indices = []
    for time_s, _, launch_deg, _, surface, bottom in case["arrivals"]:
        apart = np.abs(found.time_s - time_s) + 1e-3 * np.abs(np.degrees(found.launch_rad) - launch_deg)
        apart[(found.surface_bounces != surface) | (found.bottom_bounces != bottom)] = np.inf
        nearest = int(np.argmin(apart)) if len(apart) else 0
        indices.append(nearest if len(apart) and apart[nearest] < SAME else None)
    return indices


def bellhop_checks() -> list[Check]:
    """Check, by kind of profile, that BELLHOP's arrivals are found, with their times and levels, and no others."""
    checks = []
    for kind in dict.fromkeys(case["kind"] for case in kept_cases()):
        late_s, louder_db, missing, extra, compared = [0.0], [0.0], 0, 0, 0
        for case in kept_cases():
            if case["kind"] != kind:
                continue
            found = computed(case)
            indices = counterparts(found, case)
            for kept, index in zip(case["arrivals"], indices, strict=True):
                if index is None:
                    missing += 1
                    continue
                compared += 1
                late_s.append(abs(found.time_s[index] - kept[0]))
                louder_db.append(abs(found.level_db[index] - kept[1]))
            loud = np.flatnonzero(found.level_db > found.level_db.max() - 19.0)
            extra += len(set(loud.tolist()) - set(indices))
        group = f"BELLHOP, {kind}"
        checks += [
            within(group, f"missing of {compared + missing} arrivals", 0.0, missing, 1.0, 0.5),
            within(group, "others within 19 dB", 0.0, extra, 1.0, 0.5),
            at_most(group, "time, largest error", 1e6 * TIME_S, 1e6 * max(late_s), "us"),
            at_most(group, "level, largest error", LEVEL_DB, max(louder_db), "dB"),
        ]
    return checks


def survey_check(path: Path, limit_s: float) -> Check:
    """Check the two-way times of a survey after one rigid offset per ping, vertical and across.

    The ship's lever arm and draught explain these offsets.
    """
    return survey_check_of(path, survey_left_s(path), limit_s)


def survey_left_s(path: Path) -> Floats:
    """Return the residual differences between recorded and simulated two-way times, for every 13th beam."""
    levels, pings = read_soundings(path)
    thin = thinned(levels[levels[:, 0] < 12_000.0], PROFILE_WITHIN_M_S)
    profile = _core.SoundSpeedProfile(thin[:, 0], thin[:, 1])
    return np.concatenate([_left_s(profile, ping, k % EVERY) for k, ping in enumerate(pings)])


def survey_check_of(path: Path, left_s: Floats, limit_s: float) -> Check:
    """Return the check of a survey's remaining differences."""
    spread_s = 1.4826 * float(np.median(np.abs(left_s - np.median(left_s))))
    name = f"{path.stem}: robust sd of {len(left_s)} two-way times"
    return at_most("EM 302", name, 1e3 * limit_s, 1e3 * spread_s, "ms")


def _left_s(profile: _core.SoundSpeedProfile, ping: Ping, first: int) -> Floats:
    """Return the residual time differences of some of a ping's beams after fitting the two offsets."""
    rows, left = [], []
    for time_s, depth_m, across_m, along_m in zip(
        *(values[first::EVERY] for values in (ping.time_s, ping.depth_m, ping.across_m, ping.along_m)), strict=True
    ):
        far_m = math.hypot(across_m, along_m)
        found = _core.arrivals(
            profile, TRANSDUCER_M, float(depth_m), far_m, math.inf, 30e3, BOTTOMS["silt"], within_db=1e9, most_bounces=0
        )
        if not found:
            continue
        ray = found[0]
        speed = profile.at(float(depth_m))
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
