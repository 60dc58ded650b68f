"""Environment steps per second by members, observations and threads, compared with the bare C++ step.

Single-threaded cases are measured by processor time. The others, and the ratio of many threads to one, are measured by
wall time, which requires an idle machine. Actions are random; episodes end and restart as in training.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

import gymnasium
import numpy as np
import typer
from _harness import Rounds, alternated, medians, ratio, show

import uwsim.learning  # noqa: F401, registers the environments

MANY = 256
PROPRIOCEPTION, BARE = "proprioception", "bare C++ step"
KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    PROPRIOCEPTION: ("uwsim/StationKeeping-v1", {}),
    "sonar of 64 beams": ("uwsim/PipelineFollowing-v1", {}),
    "camera of 84 x 84": ("uwsim/PipelineFollowing-v1", {"camera": "front"}),
}


def main(
    rounds: Rounds = 7,
    seconds: Annotated[float, typer.Option(min=0.01, help="About how long each case takes in a round.")] = 0.3,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    cores = len(os.sched_getaffinity(0))
    counts = [(1, 1), (16, 1), *((MANY, threads) for threads in sorted({1, cores}))]
    cases: dict[str, Callable[[], tuple[float, float]]] = {}
    for kind, (name, options) in KINDS.items():
        for count, threads in counts:
            cases[f"{kind}, n = {count}, threads = {threads}"] = driven(name, count, threads, options, seconds)
    for threads in sorted({1, cores}):
        cases[f"{BARE}, n = {MANY}, threads = {threads}"] = bare(threads, seconds)
    found = alternated(cases, rounds)
    own, wall = ({name: [rate[k] for rate in rates] for name, rates in found.items()} for k in (0, 1))
    results, ratios = medians(own), {}
    for threads in sorted({1, cores}):
        case = f"n = {MANY}, threads = {threads}"
        peer = f"{BARE}, {case}"
        ratios[f"{PROPRIOCEPTION} / {BARE}, {threads} threads"] = ratio(own[f"{PROPRIOCEPTION}, {case}"], own[peer])
        for kind in KINDS if threads > 1 else ():
            one, many = (wall[f"{kind}, n = {MANY}, threads = {n}"] for n in (1, threads))
            ratios[f"{kind}, {threads} threads / 1"] = ratio(many, one)
    show("environment steps of all members a second, and ratios", results | ratios)
    return {"steps_s": results, "ratios": ratios}


def rates(step: Callable[[int], object], members: int, threads: int, seconds: float) -> tuple[float, float]:
    """Call step(0), step(1), ... for about `seconds`; return steps of all members a second by own clock and wall time.

    The own clock is processor time, or wall time if there are several threads.
    """
    clock = time.process_time if threads == 1 else time.perf_counter
    calls, begin, wall_begin = 0, clock(), time.perf_counter()
    while (elapsed := clock() - begin) < seconds or calls < 1:
        step(calls)
        calls += 1
    return calls * members / elapsed, calls * members / (time.perf_counter() - wall_begin)


def driven(name: str, count: int, threads: int, options: dict[str, Any], seconds: float) -> Any:
    """Return a measurement of a vector environment driven by random actions."""
    env = gymnasium.make_vec(name, count, threads=threads, **options)
    env.reset(seed=0)
    shape = (64, *(env.action_space.shape or ()))
    actions = np.random.default_rng(0).uniform(-0.3, 0.3, shape).astype(np.float32)
    return partial(rates, lambda call: env.step(actions[call % len(actions)]), count, threads, seconds)


def bare(threads: int, seconds: float) -> Any:
    """Return a measurement of the bare C++ step of as many members, without observations, rewards or episodes."""
    env: Any = gymnasium.make_vec(KINDS[PROPRIOCEPTION][0], MANY, threads=threads).unwrapped
    env.reset(seed=0)
    batch, steps = env.episodes.batch, env.episodes.steps
    batch.step(1, np.random.default_rng(0).uniform(-0.3, 0.3, (MANY, 6)))
    return partial(rates, lambda call: batch.step(steps), MANY, threads, seconds)
