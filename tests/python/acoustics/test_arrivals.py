"""All arrivals between two points, compared with those that BELLHOP computed (tests/python/data/README.md)."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim.acoustics import Arrivals, arrivals

KEPT = json.loads((Path(__file__).parents[1] / "data" / "bellhop_arrivals.json").read_text())


def computed(case: dict[str, Any]) -> Arrivals:
    profile, bottom = case["profile"], case["bottom"]
    return arrivals(profile, case["source_depth_m"], case["receiver_depth_m"], case["range_m"], bottom, within_db=40)


def counterpart(found: Arrivals, kept: list[float]) -> int | None:
    """Return the index of the arrival with the same bounces and nearly the same launch angle and time."""
    time_s, _, launch_deg, _, surface, bottom = kept
    apart = np.abs(found.time_s - time_s) + 1e-3 * np.abs(np.degrees(found.launch_rad) - launch_deg)
    apart[(found.surface_bounces != surface) | (found.bottom_bounces != bottom)] = np.inf
    nearest = int(np.argmin(apart))
    return nearest if apart[nearest] < 2e-3 else None


@pytest.mark.parametrize("number", range(len(KEPT)))
def test_every_arrival_of_bellhop_is_found_and_no_other(number: int) -> None:
    """Within 20 dB of the strongest: to 2 us, 0.1 dB and 1 degree of phase, whose sign is the opposite in BELLHOP."""
    case = KEPT[number]
    found = computed(case)
    matched = set()
    for kept in case["arrivals"]:
        index = counterpart(found, kept)
        assert index is not None, f"missing: {kept}"
        matched.add(index)
        assert found.time_s[index] == pytest.approx(kept[0], abs=2e-6)
        assert found.level_db[index] == pytest.approx(kept[1], abs=0.1)
        turned = np.degrees(found.phase_rad[index]) + kept[3]
        assert abs((turned + 180.0) % 360.0 - 180.0) < 1.0
    loud = set(np.flatnonzero(found.level_db > found.level_db.max() - 19.0).tolist())
    assert loud <= matched, f"not among BELLHOP's: {found.time_s[sorted(loud - matched)]}"


def test_rays_that_bounce_and_turn_are_among_them() -> None:
    """Four cases in 100 m of water whose strongest paths were once taken for a shadow zone."""
    for source_m, receiver_m, range_m, slope, time_s in (
        (20.0, 60.0, 1000.0, 0.5, 0.669779),
        (46.9, 11.3, 1889.0, 0.5, 1.266011),
        (74.6, 79.8, 1998.0, 0.5, 1.330580),
        (86.6, 65.5, 1647.0, -0.5, 1.143781),
    ):
        found = arrivals([(0, 1480), (100, 1480 + 100 * slope)], source_m, receiver_m, range_m)
        nearest = int(np.argmin(np.abs(found.time_s - time_s)))
        assert found.time_s[nearest] == pytest.approx(time_s, abs=1e-5)
        bounces = found.surface_bounces if slope > 0 else found.bottom_bounces
        assert bounces[nearest] == 1
        assert found.turns[nearest] >= 1


def test_the_limits_keep_the_strongest() -> None:
    profile = [(0, 1500), (50, 1490)]
    every = arrivals(profile, 20, 30, 800, within_db=60)
    few = arrivals(profile, 20, 30, 800, within_db=60, most=4)
    assert np.array_equal(few.level_db, every.level_db[np.sort(np.argsort(-every.level_db)[:4])])
    near = arrivals(profile, 20, 30, 800, within_db=10)
    assert len(near) == np.count_nonzero(every.level_db >= every.level_db.max() - 10.0)
    assert len(arrivals(profile, 20, 30, 800, bottom=None)) < len(every)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"source_depth_m": 60.0}, "from_depth_m = 60 m: must be between the surface and the bottom"),
        ({"profile": [1500.0]}, "profile has shape (1,): must be (n, 2)"),
        ({"bottom": "mud"}, "bottom = 'mud': must be one of clay, silt, sand, gravel"),
        ({"bottom": (0.0, 1.0, 1.0)}, "must be density [0.5, 10]"),
        ({"frequency_hz": 0.0}, "frequency_hz = 0 Hz: must be at least 1 Hz"),
        ({"range_m": 2e6}, "across_m = 2e+06 m: must be in [0, 1e6] m"),
    ],
)
def test_bad_input_is_refused(wrong: dict[str, Any], message: str) -> None:
    good = {"profile": [(0, 1500), (50, 1490)], "source_depth_m": 20, "receiver_depth_m": 30, "range_m": 800}
    with pytest.raises(ValueError, match=re.escape(message)):
        arrivals(**(good | wrong))
