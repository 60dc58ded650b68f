"""Frames per second of the ROV's front camera on the lake, compared with bare Embree casting the same rays.

Each frame is at a different time, so that waves, ripples and noise are recomputed. The native peer builds its tree from
the same triangles, receives the same sixteen-ray packets that the images cast (primary, shadow and shaft rays) and
casts them on as many threads. On a busy machine only ratios of all threads' processor time mean much.
"""

from __future__ import annotations

import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from _harness import Case, Rounds, alternated, embree_alone, medians, ratio, show

from uwsim import Simulator

PLACE_M = (-67.0, -52.0, -26.0)  # two metres above the bed, in front of a gate
GOALS = {"frames_per_s": ">= 60", "against_bare": "<= 1.6", "geometry_against_bare": "<= 1.15"}


def main(
    rounds: Rounds = 15, threads: Annotated[int, typer.Option(min=1, help="Threads of each case.")] = 2
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    sim = Simulator("lake", threads=threads)
    sim.rov.release()
    sim.rov.place(PLACE_M)
    for lamp in sim.rov.lamps.values():
        lamp.on = True
    camera = sim.rov.cameras["front"]

    def times_s(geometry_only: bool) -> tuple[float, float]:
        """Return wall and processor time of a frame, without the simulation step before it."""
        sim.step()
        sim.rov.place(PLACE_M)
        wall_s, processor_s = time.perf_counter(), time.process_time()
        camera.capture(geometry_only=geometry_only)
        return time.perf_counter() - wall_s, time.process_time() - processor_s

    cases: dict[str, Case] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, geometry_only in (("all", False), ("geometry", True)):
            cases[name] = partial(times_s, geometry_only)
            packets, eye_m = camera.record_rays(geometry_only=geometry_only)
            if peer := embree_alone(Path(folder) / name, sim.world, eye_m, bytes(packets), threads):
                cases[f"bare_{name}"] = peer.times_s
        found = alternated(cases, rounds, warm_up=True)
    wall, processor = ({name: [each[k] for each in times] for name, times in found.items()} for k in (0, 1))
    results = {f"{name}_s": value for name, value in medians(wall).items()}
    results["frames_per_s"] = 1 / results["all_s"]
    if "bare_all" in found:
        for name, case in (("", "all"), ("geometry_", "geometry")):
            results[f"{name}against_bare"] = ratio(wall[case], wall[f"bare_{case}"])
            results[f"{name}processor_against_bare"] = ratio(processor[case], processor[f"bare_{case}"])
    show(f"{camera.info.width} x {camera.info.height}, {threads} threads, every effect", results, GOALS)
    return results
