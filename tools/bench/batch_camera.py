"""Pictures of 84 x 84 pixels from all members of a batch, compared with Embree alone casting the same rays.

The members are those of the pipeline environment, shortly after their random starts, with the effects of its
observations. The cases alternate within one run, on one thread and on two; results are medians over the rounds, and
ratios are computed per round. A step is one of the environment, which includes twenty steps of the dynamics.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import numpy as np
import typer
from _harness import NativePeer, alternated, console, medians, native_program, ratio, spent_s
from rich.table import Table

import uwsim.learning  # noqa: F401, registers the environments
from uwsim import Batch
from uwsim.learning.eye import EFFECTS

MEMBERS, SIDE = 256, 84
THREADS = (1, 2)
PACKET = np.dtype([("kind", "<i4"), ("active", "<i4", 16), ("origin", "<f4", (3, 16)), ("others", "<f4", (5, 16))])
GOAL = 4000.0  # environment steps of all members a second, on two threads


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often to measure each case; medians are reported.")] = 9,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    cases: dict[str, Callable[[], float]] = {}
    peers = []
    with tempfile.TemporaryDirectory() as folder:
        for threads in THREADS:
            name = "uwsim/PipelineFollowing-v1"
            env: Any = gymnasium.make_vec(name, MEMBERS, threads=threads, camera="front").unwrapped
            env.reset(seed=0)
            env.step(np.zeros(env.action_space.shape, np.float32))
            cases[f"pictures, threads = {threads}"] = pictures(env.episodes.batch)
            if threads == THREADS[0] and (program := native_program("embree_bare_rays")):
                file = Path(folder) / "rays"
                rays = write_rays(file, env.episodes.batch)
                for count in THREADS:
                    peers.append(NativePeer(program, file, count, "quads"))
                    cases[f"Embree alone, threads = {count}"] = lambda peer=peers[-1]: float(peer.times_s()[0])
            cases[f"environment steps, threads = {threads}"] = steps(env)
        found = alternated(cases, rounds, warm_up=True)
        for peer in peers:
            peer.close()
    results, ratios = medians(found), compared(found)
    if peers:
        console.print(f"{MEMBERS} pictures of {SIDE} x {SIDE} pixels: {rays:,} rays")
    console.print(_table(results, ratios))
    return {"seconds": results, "ratios": ratios}


def pictures(batch: Batch) -> Callable[[], float]:
    """Return a function that renders a picture of each member and returns the seconds of wall time."""
    return lambda: spent_s(lambda: batch.capture("front", EFFECTS, size=(SIDE, SIDE)), time.perf_counter)


def steps(env: Any) -> Callable[[], float]:
    """Return a function that takes an environment step in each member and returns the seconds of wall time."""
    actions = np.zeros(env.action_space.shape, np.float32)
    return lambda: spent_s(lambda: env.step(actions), time.perf_counter)


def write_rays(file: Path, batch: Batch) -> int:
    """Write the world's surface and the ray packets of all members' pictures for the peer; return the rays' number."""
    packets, first_eye = [], None
    for k in range(batch.n):
        own, eye = batch.aboard(k).rov.cameras["front"].resized(SIDE, SIDE).record_rays(EFFECTS, colours_only=True)
        first_eye = eye if first_eye is None else first_eye
        packets.append(np.frombuffer(own, PACKET).copy())
        packets[-1]["origin"] += (eye - first_eye).astype(np.float32)[:, None]
    vertices, triangles, _ = batch.world.surface_mesh()
    every = np.concatenate(packets)
    with file.open("wb") as out:
        np.array([len(vertices), len(triangles), len(every)], np.uint64).tofile(out)
        (vertices - first_eye).astype(np.float32).tofile(out)
        triangles.astype(np.uint32).tofile(out)
        every.tofile(out)
    return int(np.count_nonzero(every["active"]))


def compared(found: dict[str, list[float]]) -> dict[str, float]:
    """Return medians of the per-round ratios."""
    ratios = {}
    for threads in THREADS:
        if (peer := f"Embree alone, threads = {threads}") in found:
            name = f"pictures / Embree alone, threads = {threads}"
            ratios[name] = ratio(found[f"pictures, threads = {threads}"], found[peer])
    for case in ("pictures", "Embree alone", "environment steps"):
        if f"{case}, threads = 1" in found:
            ratios[f"{case}, two threads over one"] = ratio(
                found[f"{case}, threads = 1"], found[f"{case}, threads = 2"]
            )
    return ratios


def _table(results: dict[str, float], ratios: dict[str, float]) -> Table:
    table = Table("case", "us a member", "members/s", "goal", title="medians, wall time")
    for name, seconds in results.items():
        rate = MEMBERS / seconds
        goal = f"{GOAL:,.0f}: {'met' if rate >= GOAL else 'missed'}" if name == "environment steps, threads = 2" else ""
        table.add_row(name, f"{1e6 * seconds / MEMBERS:.0f}", f"{rate:,.0f}", goal)
    for name, value in ratios.items():
        table.add_row(name, f"{value:.2f}", "", "")
    return table
