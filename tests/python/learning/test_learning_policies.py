"""CMA-ES finds a policy, and the packaged one keeps station better than the PID gains in the vehicle's file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from uwsim.learning.episodes import Episodes
from uwsim.learning.evolve import Generation, evolve, free_weights
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.pid import Pid
from uwsim.learning.policy import LinearPolicy
from uwsim.learning.returns import Flown, fly
from uwsim.learning.tasks import PipelineFollowing, StationKeeping

HELD_OUT = range(1_000_000, 1_000_006)


def settled_m(flown: Flown) -> float:
    """Return the rms distance from the target position after the first 10 s."""
    return float(np.sqrt((flown.figures["distance_m"][200:] ** 2).mean()))


def test_the_packaged_policy_beats_the_pid_of_the_vehicles_file_in_gusts() -> None:
    arena = Episodes(StationKeeping, len(HELD_OUT), EpisodeOptions(threads=1, normalise=False))
    pid = fly(arena, Pid(arena, StationKeeping.place_m), HELD_OUT)
    learned = fly(arena, LinearPolicy.load("station_keeping"), HELD_OUT)
    assert pid.total.min() > 250.0  # out of 400: the PID controller does keep station
    assert (learned.total > pid.total).all()
    assert learned.total.mean() > pid.total.mean() + 10.0
    assert settled_m(learned) < settled_m(pid)


def test_a_few_generations_find_a_better_policy() -> None:
    weights = np.zeros((6, 21))
    for axis in range(3):
        weights[axis, axis], weights[axis, 9 + axis] = 0.1, -0.1  # a weak pull towards the target, with damping
    start, options = LinearPolicy(weights, np.zeros(6)), EpisodeOptions(threads=1, duration_s=4.0, normalise=False)
    search, course = {"candidates": 10, "episodes_each": 3, "start": start, "spread": 0.1}, []
    found = evolve(StationKeeping, options, generations=12, **search, notify=course.append)
    arena = Episodes(StationKeeping, len(HELD_OUT), options)
    assert fly(arena, found, HELD_OUT).total.mean() > fly(arena, start, HELD_OUT).total.mean() + 3.0
    assert [generation.index for generation in course] == list(range(12))
    assert isinstance(course[0], Generation) and course[0].best >= course[0].mean


def test_a_search_repeats_to_the_byte_on_any_number_of_threads() -> None:
    one, two = (
        evolve(StationKeeping, EpisodeOptions(threads=threads, duration_s=1.0), generations=2, candidates=6)
        for threads in (1, 2)
    )
    assert one.weights.tobytes() == two.weights.tobytes()


def test_a_mirrored_case_gets_the_mirrored_action() -> None:
    free = free_weights(StationKeeping)
    assert free.sum() == 66
    weights = np.where(free, np.random.default_rng(1).normal(size=free.shape), 0.0)
    policy = LinearPolicy(weights[:, :-1], weights[:, -1])
    seen = np.random.default_rng(2).uniform(-0.1, 0.1, 21)
    mirror = np.array([factor for field in StationKeeping.fields() for factor in field.mirror])
    assert policy(mirror * seen) == pytest.approx(np.array(StationKeeping.action_mirror()) * policy(seen))
    assert free_weights(PipelineFollowing).all()


def test_a_policy_is_written_and_read(tmp_path: Path) -> None:
    policy = LinearPolicy(np.arange(6.0).reshape(2, 3) / 7.0, np.zeros(2), {"found_by": "hand"})
    policy.save(tmp_path / "policy.json")
    read = LinearPolicy.load(tmp_path / "policy.json")
    assert read.weights == pytest.approx(policy.weights, rel=1e-5)
    assert read.about == {"found_by": "hand"}
    (tmp_path / "bad.json").write_text('{"weights": [[1, 2]], "bias": [1, 2]}')
    with pytest.raises(ValueError, match="do not fit"):
        LinearPolicy.load(tmp_path / "bad.json")
    with pytest.raises(OSError, match="nowhere"):
        LinearPolicy.load("nowhere")
