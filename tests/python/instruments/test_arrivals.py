"""All arrivals between two points, compared with those that BELLHOP computed (tests/python/data/README.md)."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from uwsim.cli.program import app
from uwsim.evidence.validate import sound
from uwsim.evidence.validate.reality import soundings
from uwsim.evidence.validate.sound import computed, counterparts, kept_cases
from uwsim.instruments.acoustics import arrivals
from uwsim.instruments.acoustics.rays_between import ray_path

SURVEYS = Path(__file__).parents[4] / "shared/reality/gsf"


@pytest.mark.parametrize("kind", dict.fromkeys(case["kind"] for case in kept_cases()))
def test_every_arrival_of_bellhop_is_found_and_no_other(kind: str) -> None:
    """Within 20 dB of the strongest: to 10 us, 1 dB and 5 degrees of phase, whose sign is the opposite in BELLHOP."""
    for case in kept_cases():
        if case["kind"] != kind:
            continue
        found = computed(case)
        indices = counterparts(found, case)
        assert None not in indices
        for kept, index in zip(case["arrivals"], indices, strict=True):
            assert found.time_s[index] == pytest.approx(kept[0], abs=10e-6)
            assert found.level_db[index] == pytest.approx(kept[1], abs=1.0)
            turned = np.degrees(found.phase_rad[index]) + kept[3]
            assert abs((turned + 180.0) % 360.0 - 180.0) < 5.0
        loud = set(np.flatnonzero(found.level_db > found.level_db.max() - 19.0).tolist())
        assert loud <= set(indices), f"not among BELLHOP's: {found.time_s[sorted(loud - set(indices))]}"


def test_the_suite_has_a_check_for_each_kind_and_each_can_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    checks = sound.run()
    assert len(checks) == 20
    assert all(check.passed for check in checks)
    straight = [case | {"profile": [[0.0, 1500.0], [case["profile"][-1][0], 1500.0]]} for case in kept_cases()]
    monkeypatch.setattr(sound, "kept_cases", lambda: straight)
    assert all(any(not one.passed for one in sound.run() if kind in one.group) for kind in ("lake", "Munk"))


@pytest.mark.parametrize("name", soundings.SURVEYS)
def test_two_way_times_of_a_recorded_survey_are_met(name: str) -> None:
    if not (SURVEYS / name).is_file():
        pytest.skip(f"no {SURVEYS / name}")
    assert soundings.survey_check(SURVEYS / name, soundings.SURVEYS[name]).passed


@pytest.mark.parametrize(
    ("profile", "source_m", "receiver_m", "range_m", "bottom_m"),
    [
        ([(0, 1480), (100, 1530)], 20.0, 60.0, 1000.0, 100.0),
        ([(0, 1480), (5, 1478), (15, 1440), (60, 1435)], 20.0, 45.0, 350.0, 60.0),
        ([(0, 1500), (50, 1500)], 20.0, 30.0, 200.0, 50.0),
        ([(0, 1500), (50, 1480), (200, 1490)], 40.0, 60.0, 700.0, math.inf),
    ],
)
def test_every_ray_drawn_ends_at_the_receiver(
    profile: list[tuple[float, float]], source_m: float, receiver_m: float, range_m: float, bottom_m: float
) -> None:
    """Arcs drawn one after another meet the receiver that the search solved for, with as many reflections."""
    bottom = None if math.isinf(bottom_m) else "sand"
    found = arrivals(profile, source_m, receiver_m, range_m, bottom, within_db=25)
    assert len(found) > 1
    for launch_rad, surface, bed in zip(found.launch_rad, found.surface_bounces, found.bottom_bounces, strict=True):
        path = ray_path(profile, bottom_m, source_m, launch_rad, range_m)
        assert path[-1] == pytest.approx((range_m, receiver_m), abs=2e-3)
        assert np.count_nonzero(path[:, 1] < 1e-9) == surface
        assert np.count_nonzero(path[:, 1] > bottom_m - 1e-9) == bed


def test_the_command_prints_and_draws_the_rays(tmp_path: Path) -> None:
    command = ["scenario", "rays", "pool", "--from=0,0,-1", "--to=2,1,-2", "--out", str(tmp_path / "rays.svg")]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    direct_s = math.sqrt(6.0) / 1482.5  # fresh water at 20 deg C
    assert any(line.split()[0] == f"{direct_s:.6f}" for line in result.output.splitlines() if line[:4] == "    ")
    assert (tmp_path / "rays.svg").read_text().count("<path") > 10
    first = (tmp_path / "rays.svg").read_bytes()
    CliRunner().invoke(app, command)
    assert (tmp_path / "rays.svg").read_bytes() == first
    with pytest.raises(ValueError, match=re.escape("--to 0,0,5: must be in the water")):
        CliRunner().invoke(app, ["scenario", "rays", "pool", "--from=0,0,-1", "--to=0,0,5"], catch_exceptions=False)


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
        ({"bottom": (1.5, 1.1)}, "bottom = (1.5, 1.1): must be three numbers, density [0.5, 10]"),
        ({"bottom": 1.5}, "bottom = 1.5: must be three numbers"),
        ({"frequency_hz": 0.0}, "frequency_hz = 0 Hz: must be at least 1 Hz"),
        ({"range_m": 2e6}, "across_m = 2e+06 m: must be in [0, 1e6] m"),
    ],
)
def test_bad_input_is_refused(wrong: dict[str, Any], message: str) -> None:
    good = {"profile": [(0, 1500), (50, 1490)], "source_depth_m": 20, "receiver_depth_m": 30, "range_m": 800}
    with pytest.raises(ValueError, match=re.escape(message)):
        arrivals(**(good | wrong))
