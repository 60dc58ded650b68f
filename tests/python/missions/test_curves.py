"""Curved paths: through the waypoints, no tighter than the turning radius, none shorter, and vehicles follow them."""

import math

import numpy as np
import pytest

import uwsim
from uwsim.missions.dubins import dubins_pieces, dubins_points
from uwsim.missions.planners.curves import dubins_path, fly_through, spline_path

POINTS_M = np.array([[0, 0, -2], [12, 0, -3], [12, 9, -4], [-3, 6, -2]], float)


def test_a_dubins_path_turns_no_tighter_than_its_radius() -> None:
    radius_m, step_m = 2.5, 0.05
    path = dubins_path(POINTS_M, radius_m, 0.5 * math.pi, step_m)
    steps = np.diff(path[:, :2], axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    assert lengths.max() <= step_m * 1.001
    turns = np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0])))))
    assert (turns <= lengths[:-1] / radius_m * 1.1 + 1e-6).all()
    for point in POINTS_M:
        assert np.linalg.norm(path - point, axis=1).min() < 1e-3
    assert math.atan2(*steps[0][::-1]) == pytest.approx(0.5 * math.pi, abs=0.05)


def test_two_points_in_line_are_joined_by_a_straight_line_and_a_turn_back_is_longer() -> None:
    ahead, back = (dubins_path([[0, 0], [8, 0]], 2.0, heading, 0.1) for heading in (0.0, math.pi))
    assert np.abs(ahead[:, 1]).max() < 1e-6
    lengths = [np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in (ahead, back)]
    assert lengths[0] == pytest.approx(8.0, abs=1e-3) and lengths[1] > 8.0 + 2.0 * math.pi


def test_a_spline_passes_through_its_points_and_reproduces_a_cubic() -> None:
    path = spline_path(POINTS_M, 0.2)
    for point in POINTS_M:
        assert np.linalg.norm(path - point, axis=1).min() < 1e-9
    assert spline_path([[0, 0], [4, 2]])[:, 1] == pytest.approx(0.5 * spline_path([[0, 0], [4, 2]])[:, 0])


@pytest.mark.parametrize("curve", ["dubins", "spline"])
def test_a_vehicle_flies_through_the_waypoints(curve: str) -> None:
    waypoints = [(3.0, 3.0, -2.5), (-2.0, 4.0, -2.0), (-3.0, -4.0, -2.5)]

    def mission(vehicle):
        vehicle.undock()
        return (yield from fly_through(vehicle, waypoints, curve=curve, radius_m=1.5, speed_m_s=0.4))

    flown = uwsim.fly(mission, "pool")
    assert not flown.ended_early, flown.ended_because
    track = flown.samples["rov"].path_world_m
    for point in waypoints:
        assert np.linalg.norm(track - point, axis=1).min() < 0.7
    off_m = np.array([np.linalg.norm(flown.result - place, axis=1).min() for place in track[20:]])
    assert np.sqrt(np.mean(off_m**2)) < 0.5


def test_a_vehicle_stops_before_what_is_in_the_way_of_its_curve() -> None:
    def mission(vehicle):
        vehicle.undock()
        waypoints = [(-8.0, -16.0), (2.0, -14.0), (2.0, -4.0), (-10.0, -4.0)]  # the spline swings out into a gate post
        yield from fly_through(vehicle, waypoints, curve="spline", altitude_m=3.0)

    flown = uwsim.fly(mission, "cove")
    assert flown.ended_because.endswith("in the way of the curve")
    assert flown.collisions == 0


@pytest.mark.parametrize(
    ("points", "radius_m", "match"),
    [([[0, 0]], 1.0, "n at least 2"), ([[0, 0], [0, 0]], 1.0, "coincide"), ([[0, 0], [1, 1]], 0.0, "must be positive")],
)
def test_what_is_no_path_is_refused(points, radius_m, match) -> None:
    with pytest.raises(ValueError, match=match):
        dubins_path(points, radius_m, 0.0)


CASES = (
    np.random.default_rng(1).uniform((-10, -10, -4, -10, -10, -4, 0.5), (10, 10, 4, 10, 10, 4, 8), (200, 7)).tolist()
)


@pytest.mark.parametrize("case", CASES[:20])
def test_it_leads_from_pose_to_pose_and_turns_no_tighter(case):
    start, end, radius_m = tuple(case[:3]), tuple(case[3:6]), case[6]
    points = dubins_points(start, end, radius_m, step_m=0.01)
    assert points[0] == pytest.approx(start[:2]) and points[-1] == pytest.approx(end[:2], abs=1e-9)
    chords = np.diff(points, axis=0)
    headings = np.unwrap(np.arctan2(chords[:, 1], chords[:, 0]))
    for heading, given in ((headings[0], start[2]), (headings[-1], end[2])):
        assert math.cos(heading - given) > 1.0 - 1e-4
    assert (np.abs(np.diff(headings)) <= 1.01 * np.linalg.norm(chords[1:], axis=1) / radius_m + 1e-3).all()


def test_it_is_as_long_as_the_open_motion_planning_librarys():
    base = pytest.importorskip("ompl.base")
    for case in CASES:
        space = base.DubinsStateSpace(case[6])
        states = [space.allocState(), space.allocState()]
        for state, (x, y, heading) in zip(states, (case[:3], case[3:6]), strict=True):
            state.setXY(x, y)
            state.setYaw(math.remainder(heading, 2.0 * math.pi))
        length_m = sum(length for _, length in dubins_pieces(tuple(case[:3]), tuple(case[3:6]), case[6]))
        assert length_m == pytest.approx(space.distance(*states), abs=1e-6)
