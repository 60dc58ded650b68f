"""Dubins paths: they end where they should, never turn tighter, and none of the library's is shorter."""

import math

import numpy as np
import pytest

from uwsim.missions.dubins import dubins_pieces, dubins_points

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
