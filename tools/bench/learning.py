"""Environment steps per second by members, observations and threads, compared with the bare C++ step and pybullet.

All cases alternate in each round; medians of rates, and of per-round ratios, are reported. Single-threaded cases are
measured by processor time. The others, and the ratio of many threads to one, are measured by wall time, which
requires an idle machine. Actions are random; episodes end and restart as in training.
"""

from __future__ import annotations

import os
import runpy
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import gymnasium
import numpy as np
import typer
from _harness import alternated, console, medians, ratio
from rich.table import Table

import uwsim.learning  # noqa: F401, registers the environments

COUNTS = (1, 16, 256)
KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "proprioception": ("uwsim/StationKeeping-v1", {}),
    "sonar of 64 beams": ("uwsim/PipelineFollowing-v1", {}),
    "camera of 84 x 84": ("uwsim/PipelineFollowing-v1", {"camera": "front"}),
}
GOAL = 0.5  # share of the bare C++ step's rate, for 256 members and proprioception
MARINEGYM = 250_000
MARINEGYM_SOURCE = "MarineGym, arXiv:2503.09203, abstract: frames a second on an RTX 3060; not measured here"


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often each case is measured. Medians are reported.")] = 7,
    seconds: Annotated[float, typer.Option(min=0.01, help="About how long each case takes in a round.")] = 0.3,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    cores = len(os.sched_getaffinity(0))
    cases: dict[str, Callable[[float], Rate]] = {}
    for kind, (name, options) in KINDS.items():
        for count in COUNTS:
            for threads in sorted({1, cores}) if count == max(COUNTS) else (1,):
                cases[f"{kind}, n = {count}, threads = {threads}"] = Driven(name, count, threads, options)
    for threads in sorted({1, cores}):
        cases[f"bare C++ step, n = {max(COUNTS)}, threads = {threads}"] = Bare(KINDS["proprioception"][0], threads)
    if (peer := pybullet_step()) is not None:
        cases["pybullet and NumPy, one vehicle"] = peer
    else:
        console.print("without pybullet: not installed (pip install pybullet)")
    found = alternated({name: partial(measure, seconds) for name, measure in cases.items()}, rounds)
    results = medians({name: [rate.own for rate in rates] for name, rates in found.items()})
    ratios = compared(found, cores)
    console.print(rates_table(results))
    console.print(ratios_table(ratios))
    console.print(f"on paper: {MARINEGYM:,} ({MARINEGYM_SOURCE})")
    return {"steps_s": results, "ratios": ratios}


class Rate(NamedTuple):
    """Environment steps per second of all members, by the case's own clock and by wall time."""

    own: float
    wall: float


def timed(step: Callable[[int], object], members: int, threads: int, seconds: float) -> Rate:
    """Call step(0), step(1), ... for about `seconds` of processor time, or wall time if there are several threads."""
    clock = time.process_time if threads == 1 else time.perf_counter
    calls, begin, wall_begin = 0, clock(), time.perf_counter()
    while (elapsed := clock() - begin) < seconds or calls < 1:
        step(calls)
        calls += 1
    return Rate(calls * members / elapsed, calls * members / (time.perf_counter() - wall_begin))


class Driven:
    """A vector environment driven by random actions."""

    def __init__(self, name: str, count: int, threads: int, options: dict[str, Any]) -> None:
        self._env = gymnasium.make_vec(name, count, threads=threads, **options)
        self._env.reset(seed=0)
        self._threads = threads
        draws = np.random.default_rng(0)
        self._actions = draws.uniform(-0.3, 0.3, (64, *(self._env.action_space.shape or ()))).astype(np.float32)

    def __call__(self, seconds: float) -> Rate:
        """Step for about `seconds`."""

        def step(call: int) -> object:
            return self._env.step(self._actions[call % len(self._actions)])

        return timed(step, self._env.num_envs, self._threads, seconds)


class Bare:
    """The bare C++ step of as many members in the same water, without actions, observations, rewards or episodes."""

    def __init__(self, name: str, threads: int) -> None:
        env: Any = gymnasium.make_vec(name, max(COUNTS), threads=threads).unwrapped
        env.reset(seed=0)
        self._threads = threads
        self._batch, self._steps = env.episodes.batch, env.episodes.steps
        efforts = np.random.default_rng(0).uniform(-0.3, 0.3, (self._batch.n, 6))
        self._batch.step(1, efforts)

    def __call__(self, seconds: float) -> Rate:
        """Step for about `seconds`; each call is one period of an environment."""
        return timed(lambda call: self._batch.step(self._steps), self._batch.n, self._threads, seconds)


def pybullet_step() -> Callable[[float], Rate] | None:
    """Return a function that steps a BlueROV2 Heavy in pybullet for an environment's period; None without pybullet."""
    peer = runpy.run_path(str(Path(__file__).with_name("dynamics.py")))["pybullet_peer"]()
    if peer is None:
        return None
    steps_s = peer(on_bed=False)
    return lambda seconds: Rate(*[steps_s() / 10.0] * 2)  # ten pybullet steps are one period of uwsim/StationKeeping-v1


def compared(found: dict[str, list[Rate]], cores: int) -> dict[str, float]:
    """Return medians of the per-round ratios."""

    def against(one: str, other: str) -> float:
        return ratio(*([rate.own for rate in found[name]] for name in (one, other)))

    most, ratios = max(COUNTS), {}
    for threads in sorted({1, cores}):
        case, tail = f"n = {most}, threads = {threads}", f", {threads} thread(s)"
        ratios[f"proprioception / bare C++ step{tail}"] = against(f"proprioception, {case}", f"bare C++ step, {case}")
    for kind in KINDS if cores > 1 else ():
        few, many = (f"{kind}, n = {most}, threads = {threads}" for threads in (1, cores))
        ratios[f"{kind}, {cores} threads / 1"] = ratio(*([rate.wall for rate in found[name]] for name in (many, few)))
    if "pybullet and NumPy, one vehicle" in found:
        one = f"proprioception, n = {most}, threads = 1"
        ratios["proprioception / pybullet and NumPy, 1 thread"] = against(one, "pybullet and NumPy, one vehicle")
    return ratios


def rates_table(results: dict[str, float]) -> Table:
    """Return the rates as a table."""
    table = Table("case", "environment steps/s", title="environment steps of all members a second: medians")
    for name, rate in results.items():
        table.add_row(name, f"{rate:,.0f}")
    return table


def ratios_table(ratios: dict[str, float]) -> Table:
    """Return the ratios as a table."""
    table = Table("ratio", "median", "goal")
    for name, value in ratios.items():
        goal = f"{GOAL:g}: {'met' if value >= GOAL else 'missed'}" if "bare" in name else ""
        table.add_row(name, f"{value:.2f}", goal)
    return table
