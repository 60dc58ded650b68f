"""Planners that go by what the sonar sees: a pipeline is followed to its end, a gate is passed in its middle."""

import math
from itertools import pairwise

import numpy as np
import pytest

import uwsim
from uwsim.missions import StoppedError, goto
from uwsim.missions.planners.gate import gate_posts, pass_gate
from uwsim.missions.planners.pipeline import crossings, follow_pipeline

PIPE_M = np.array([[-20, -6], [-8, -9], [4, -6], [16, -10]], float)
GATE_M, GATE_WIDTH_M, GATE_HEIGHT_M = np.array([-4.0, 2.0]), 4.0, 4.0


def off_pipe_m(points_m: np.ndarray) -> np.ndarray:
    """Distances (n,) of points (n, 2) from the pipe's line."""
    nearest = [
        a + np.clip((points_m - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)[:, None] * (b - a)
        for a, b in pairwise(PIPE_M)
    ]
    return np.min([np.linalg.norm(points_m - near, axis=1) for near in nearest], axis=0)


@pytest.mark.parametrize("start", ["west", "east"])
def test_a_pipeline_is_followed_to_its_end_by_sonar(start: str) -> None:
    begin_m, heading_rad = ((-19.0, -5.0), -0.3) if start == "west" else ((17.0, -8.5), math.pi - 0.3)

    def mission(vehicle):
        vehicle.undock()
        return (yield from follow_pipeline(vehicle, begin_m, heading_rad))

    flown = uwsim.fly(mission, "cove")
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    track = flown.result
    assert off_pipe_m(track.crossings_m).max() < 0.4
    end_m = PIPE_M[-1] if start == "west" else PIPE_M[0]
    assert np.linalg.norm(track.crossings_m[-1] - end_m) < 1.0
    assert track.length_m > 20.0 and track.pictures == pytest.approx(track.length_m / 5.0, abs=2.0)
    found_s = next(event.time_s for event in flown.events if event.name == "pipe_found")
    samples = flown.samples["rov"]
    on_it = (samples["time_s"] > found_s + 15.0) & (samples["time_s"] < flown.simulated_s - 30.0)
    assert np.sqrt(np.mean(off_pipe_m(samples.path_world_m[on_it, :2]) ** 2)) < 0.6


def test_where_there_is_no_pipe_it_says_so() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from follow_pipeline(vehicle, (-12.0, -18.0), 0.0, search_m=8.0)

    assert uwsim.fly(mission, "cove").ended_because == "no pipe was found within 8 m"


def test_a_bump_is_a_pipe_only_if_it_has_its_width() -> None:
    across_m = np.linspace(-8.0, 8.0, 400)
    bed = np.column_stack([np.full(400, 5.0), across_m, -9.0 + 0.05 * across_m])
    assert len(crossings(bed.astype(float), 0.8)) == 0
    piped = bed.copy()
    piped[np.abs(across_m - 2.0) < 0.4, 2] += 0.6
    assert crossings(piped, 0.8) == pytest.approx(np.array([[5.0, 2.0]]), abs=0.05)
    assert len(crossings(piped, 6.0)) == 0 and len(crossings(piped, 0.1)) == 0


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
