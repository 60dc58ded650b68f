"""Gates detected by the sonar are passed through their centre."""

import math
from itertools import pairwise

import numpy as np
import pytest

import uwsim
from uwsim.missions import StoppedError, goto, run
from uwsim.missions.planners import next_best_view
from uwsim.missions.planners.gate import gate_posts, pass_gate

GATE_M, GATE_WIDTH_M, GATE_HEIGHT_M = np.array([-4.0, 2.0]), 4.0, 4.0


def test_a_gate_is_passed_in_its_middle_from_both_sides() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (-13.0, 0.0), altitude_m=3.0)
        there = yield from pass_gate(vehicle, GATE_M + 1.0, GATE_WIDTH_M, GATE_HEIGHT_M)
        back = yield from pass_gate(vehicle, GATE_M + 1.0, GATE_WIDTH_M, GATE_HEIGHT_M)
        return there, back

    flown = uwsim.fly(mission, "cove")
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    for gate, heading_rad in zip(flown.result, (0.0, math.pi), strict=True):
        assert np.linalg.norm(gate.middle_m - GATE_M) < 0.3
        assert abs(math.remainder(gate.heading_rad - heading_rad, 2.0 * math.pi)) < math.radians(5.0)
    path = flown.samples["rov"].path_world_m
    through = [
        a + (GATE_M[0] - a[0]) / (b[0] - a[0]) * (b - a) for a, b in pairwise(path) if (a[0] < -4) != (b[0] < -4)
    ]
    assert len(through) == 2
    for point in through:
        assert abs(point[1] - GATE_M[1]) < 0.7 and point[2] < -9.0 + GATE_HEIGHT_M + 1.0


def test_a_missing_gate_is_an_end_with_a_reason() -> None:
    def mission(vehicle):
        vehicle.undock()
        try:
            yield from pass_gate(vehicle, (-4.0, -2.0), 2.0, 3.0)
        except StoppedError as stop:
            return str(stop)

    assert uwsim.fly(mission, "cove").result.startswith("no gate of 2 m is seen near")


def test_posts_make_a_gate_only_at_its_width() -> None:
    posts = np.array([[5.0, -1.0], [5.0, 3.0], [9.0, 3.0]])
    assert gate_posts(posts, np.array([5.0, 1.0]), 4.0) == pytest.approx(np.array([[5.0, 3.0], [5.0, -1.0]]))
    assert gate_posts(posts, np.array([5.0, 1.0]), 2.0) is None
    assert gate_posts(posts[:0], np.array([5.0, 1.0]), 4.0) is None


def test_an_exploration_under_all_stop_ends_with_the_reason(monkeypatch) -> None:
    """A view without a way is given up for the next; a vehicle that may not move has no next one."""
    sim, view = uwsim.Simulator("pool"), next_best_view._view

    def stopped_view(vehicle, live, goal):
        vehicle.all_stop()
        yield from view(vehicle, live, goal)

    def mission(vehicle):
        return (yield from next_best_view.next_best_view(vehicle))

    monkeypatch.setattr(next_best_view, "_view", stopped_view)
    with pytest.raises(StoppedError, match=r"^all stop is set$"):
        run(mission, sim.rov, sim)
