"""A vehicle with an arm in the simulator: it comes to rest where gravity and buoyancy have no moment."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from uwsim.evidence.validate.reality import arm_tilts
from uwsim.evidence.validate.reality.arm_tilts import (
    STATED_HULL_NM,
    Arm,
    arm_at,
    fitted_hull_nm,
    flown_deg,
    read_trials,
    rms_deg,
)

DATA = Path(__file__).parents[4] / "shared/reality/hinsdale"
POSES = [{"b": 2.879, "c": 3.0, "d": 1.6, "e": 3.07}, {"b": 0.5, "c": 0.4, "d": 3.1, "e": 4.6}]


def held(angles_rad: dict[str, float]):
    """Return an arm that stays in a pose."""
    return lambda times_s: arm_at({column: np.full(len(times_s), angle) for column, angle in angles_rad.items()})


def at_rest_deg(moment_nm: np.ndarray) -> np.ndarray:
    x, y, z = moment_nm
    return np.degrees([np.arctan2(-x, np.hypot(y, z)), np.arctan2(y, z)])


@pytest.mark.parametrize("pose", POSES)
def test_the_simulated_vehicle_rests_where_its_moment_points_up(pose: dict[str, float]) -> None:
    moment_nm = np.array(STATED_HULL_NM) + held(pose)(np.zeros(1)).moment_nm[0]
    got = flown_deg(held(pose), np.array(STATED_HULL_NM), np.array([0.0, 1.0]))
    np.testing.assert_allclose(got[-1], at_rest_deg(moment_nm), atol=0.05)


def test_a_moved_arm_tilts_the_vehicle_within_some_seconds_and_not_at_once() -> None:
    before, after = POSES

    def moved(times_s: np.ndarray) -> Arm:
        return arm_at({c: np.where(times_s < 1.0, before[c], after[c]) for c in before})

    hull = np.array(STATED_HULL_NM)
    got = flown_deg(moved, hull, np.array([0.0, 1.0, 1.1, 60.0]))
    first, last = (at_rest_deg(hull + held(pose)(np.zeros(1)).moment_nm[0]) for pose in (before, after))
    assert np.abs(last - first).max() > 5.0
    np.testing.assert_allclose(got[:2], [first, first], atol=0.05)
    assert np.abs(got[2] - first).max() < 0.3 * np.abs(last - first).max(), "it has inertia"
    np.testing.assert_allclose(got[3], last, atol=0.1)


def three_trials() -> tuple[list, list]:
    if not DATA.is_dir():
        pytest.skip(f"no {DATA}: docs/inside/reality.md lists the sources of the files")
    trials = read_trials(DATA)
    return [t for t in trials if t.name in ("traj014-2", "traj015-0", "traj026-2")], trials[::2]


def test_three_trials_are_met_by_the_hull_of_others_and_not_by_a_core_whose_statics_are_broken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judged, fitted = three_trials()
    hull = fitted_hull_nm([t for t in fitted if t not in judged])
    assert np.mean([rms_deg(flown_deg(t.arm, hull, t.times_s), t) for t in judged]) < 0.3

    def without_buoyancy_that_follows(model, **kwargs):
        sim = deep_water(model, **kwargs)
        update = sim.parameters.update

        def set_masses_only(changes):
            update({name: value for name, value in changes.items() if "buoyancy" not in name})

        monkeypatch.setattr(type(sim.parameters), "update", lambda self, changes: set_masses_only(changes))
        return sim

    deep_water = arm_tilts.deep_water
    monkeypatch.setattr(arm_tilts, "deep_water", without_buoyancy_that_follows)
    assert np.mean(rms_deg(flown_deg(judged[0].arm, hull, judged[0].times_s), judged[0])) > 2.0
