"""Total propagated uncertainty: Hare's terms for a level vehicle, and drawn errors."""

import math
from dataclasses import replace

import numpy as np
import pytest

from uwsim.mapping.files.swath import Swath
from uwsim.scoring.tpu import LIMITS, Uncertainties, deviations

C_M_S = 1500.0


def a_swath(roll_rad=0.0, pitch_rad=0.0, transducer_m=(0.0, 0.0, 0.0), depth_m=40.0) -> Swath:
    """Return a level swath of 61 beams to 60 degrees over a level bed."""
    angles = np.radians(np.linspace(-60.0, 60.0, 61))
    nan = np.full(61, np.nan)
    below_m = depth_m - transducer_m[2]
    across = transducer_m[1] - below_m * np.tan(angles)
    sounding = np.column_stack([np.full(61, transducer_m[0]), across, np.full(61, depth_m)])
    axes = np.column_stack([np.zeros(61), -np.sin(angles), np.cos(angles)])
    return Swath(
        0, 43.0, 6.0, 0.0, 0.3, pitch_rad, roll_rad, 0.3, 2.0, C_M_S, np.asarray(transducer_m, float),
        2.0 * below_m / np.cos(angles) / C_M_S, axes, sounding, angles, nan, nan, nan, nan, np.zeros(61, bool),
    )  # fmt: skip


def test_each_term_of_a_level_vehicle_is_hare_s():
    swath = a_swath()
    angle, y, z = np.abs(swath.beam_rad), np.abs(swath.sounding_m[:, 1]), 40.0
    none, one, range_m, degree = 0 * y, 1 + 0 * y, z / np.cos(angle), math.radians(1.0)
    arc = np.tan(angle) / C_M_S
    rolled, of_speed = (
        (y * degree, z * degree * one),
        (np.hypot(z / C_M_S, y * arc / 2), np.hypot(y / C_M_S, z * arc / 2)),
    )
    expected = {  # vertical and horizontal, of one unit
        "roll": rolled, "pitch": (none, z * degree * one), "heading": (none, y * degree), "angle": rolled,
        "mount": (y * degree, range_m * degree), "position": (none, one), "lever": (one, one),
        "depth": (one, none), "heave": (one, none), "tide": (one, none), "latency": (none, 2.0 * one),
        "sound_speed": of_speed, "surface_speed": (y * arc, z * arc), "range": (np.cos(angle), np.sin(angle)),
    }  # fmt: skip
    assert set(expected) == set(LIMITS)
    for term, each in expected.items():
        found = deviations(swath, Uncertainties(**{term: 0.05}))
        np.testing.assert_allclose(found, 0.05 * np.array(each), rtol=1e-9, atol=1e-12, err_msg=term)


def test_variances_add():
    every = dict.fromkeys(LIMITS, 0.1)
    swath = a_swath(pitch_rad=0.1, transducer_m=(1.0, -0.5, 0.8))
    whole = deviations(swath, Uncertainties(**every))[0] ** 2
    parts = sum(deviations(swath, Uncertainties(**{name: 0.1}))[0] ** 2 for name in LIMITS)
    np.testing.assert_allclose(whole, parts, rtol=1e-12)


def test_drawn_errors_of_attitude_have_the_stated_covariance():
    """A pitched and rolled vehicle with a lever arm: the attitude is drawn, and the rotation is scipy's."""
    from scipy.spatial.transform import Rotation

    roll, pitch, size = 0.2, -0.15, 0.3
    swath = a_swath(roll, pitch, (3.0, 1.0, 2.0))
    body = Rotation.from_euler("ZYX", [0.0, pitch, roll]).inv().apply(swath.sounding_m)
    drawn = np.radians(size) * np.random.default_rng(3).normal(size=(20_000, 3))
    turned = Rotation.from_euler("ZYX", np.array([0.0, pitch, roll]) + drawn)
    known = Uncertainties(roll=size, pitch=size, heading=size)
    vertical, horizontal = deviations(swath, known)
    for beam in (0, 20, 30, 45, 60):
        moved = turned.apply(body[beam])
        assert np.std(moved[:, 2]) == pytest.approx(vertical[beam], rel=0.03)
        assert math.sqrt(np.linalg.eigvalsh(np.cov(moved[:, :2].T))[1]) == pytest.approx(horizontal[beam], rel=0.03)


def test_a_covariance_of_the_estimate_acts_like_the_same_instruments():
    swath = a_swath(transducer_m=(1.0, 0.5, 0.3))
    turn = math.radians(0.2)
    pose = np.diag([0.4**2, 0.4**2, 0.1**2, turn**2, turn**2, turn**2])
    known = Uncertainties(position=0.4, depth=0.1, roll=0.2, pitch=0.2, heading=0.2)
    for ours, theirs in zip(deviations(swath, Uncertainties(), pose), deviations(swath, known), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12)


def test_beams_without_a_detection_have_no_uncertainty():
    swath, is_lost = a_swath(), np.arange(61) < 5
    lost = np.where(is_lost, np.nan, swath.travel_time_s)
    sounding = np.where(is_lost[:, None], np.nan, swath.sounding_m)
    vertical, horizontal = deviations(replace(swath, travel_time_s=lost, sounding_m=sounding), Uncertainties(depth=0.1))
    assert np.isnan(vertical[:5]).all() and np.isnan(horizontal[:5]).all()
    assert np.isfinite(vertical[5:]).all()


@pytest.mark.parametrize("text", ["roll", "yaw=1", "roll=1,roll=2", "roll=nan", "roll=-1", "position=1e9", ""])
def test_wrong_uncertainties_are_refused(text):
    with pytest.raises(ValueError, match="--uncertainty"):
        Uncertainties.parse(text)
