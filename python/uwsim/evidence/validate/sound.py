"""The sound suite: compares arrivals with BELLHOP's, which are stored beside this file.

tests/python/data/README.md has the recipe. Backscatter is a native test, Seabed.ReproducesThePublishedTable.
"""

from __future__ import annotations

import lzma
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.texts.json_text import json_value
from uwsim.evidence.validate.check import Check, at_most, within
from uwsim.instruments.acoustics import Arrivals, arrivals

KEPT = Path(__file__).parent / "bellhop_arrivals.json.xz"
TIME_S, LEVEL_DB = 10e-6, 1.0
SAME = 2e-3  # largest difference between arrivals taken to be the same: time [s] plus launch angle [1000 deg]


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


def run() -> list[Check]:
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
