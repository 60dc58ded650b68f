"""A wall is scanned at the requested distance, at each depth and tilt, and its end is detected."""

import numpy as np
import pytest

import uwsim
from uwsim.missions import goto, turn_to
from uwsim.missions.planners.wall import scan_wall

QUAY_Y_M, QUAY_EAST_M = 17.5, 0.0


def test_a_quay_is_scanned_with_the_sonar_tilted_up_and_down() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (-8.0, 11.0, -3.0), speed_m_s=0.8)
        yield from turn_to(vehicle, 0.4 * np.pi)  # not quite perpendicular to the wall
        return (yield from scan_wall(vehicle, 5.0, depths_m=(2.0, 4.0), tilts_deg=(-15.0, 15.0)))

    flown = uwsim.fly(mission, "cove")
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    assert [(p.depth_m, p.tilt_deg) for p in flown.result] == [(2.0, -15.0), (2.0, 15.0), (4.0, -15.0), (4.0, 15.0)]
    for scan in flown.result:
        assert scan.distance_rms_m < 0.3 and not scan.wall_ended and scan.length_m == pytest.approx(5.0, abs=0.3)
    starts_s = [event.time_s for event in flown.events if event.name == "pass"]
    samples = flown.samples["rov"]
    during = samples["time_s"] > starts_s[0]
    assert np.abs(QUAY_Y_M - samples["y_m"][during] - 4.0).max() < 0.7, "true distance"


def test_where_the_wall_ends_the_pass_ends() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (-4.0, 13.0, -3.0), speed_m_s=0.8)
        yield from turn_to(vehicle, 0.5 * np.pi)
        return (yield from scan_wall(vehicle, 12.0, distance_m=3.0, depths_m=(2.0,), tilts_deg=(0.0,)))

    (scan,) = uwsim.fly(mission, "cove").result
    assert scan.wall_ended and scan.length_m < 9.0


def test_without_a_wall_it_says_so() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from scan_wall(vehicle, 5.0)

    assert uwsim.fly(mission, "cove").ended_because == "no wall is seen within 10 m ahead"
