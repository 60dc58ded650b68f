"""Frames per second of the ROV's front camera on the lake, compared with bare Embree casting the same rays.

All cases alternate within one run, so that other load on the machine affects them equally; results are medians over the
rounds, and ratios are computed per round, of wall time and of all threads' processor time; only the latter mean much on
a busy machine. Each frame is at a different time, so that waves, ripples and noise are recomputed. The native peer
builds its tree from the same triangles, receives the same sixteen-ray packets that the images cast (primary, shadow and
shaft rays) and casts them on as many threads. With the terrain as quads, as in our own tree, the peer is faster; that
rate is also printed.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import NativePeer, alternated, console, goal_cells, native_program, new_table, ratio
from rich.table import Table

from uwsim import Simulator
from uwsim.instruments.cameras import Camera, Frame

PLACE_M = (-67.0, -52.0, -26.0)  # two metres above the bed, in front of a gate
GOALS = {"frames_per_s": 60.0, "against_bare": 1.6, "geometry_against_bare": 1.15}
Times = Sequence[float]  # wall and processor time of a case [s]


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often to measure each case; medians are reported.")] = 15,
    threads: Annotated[int, typer.Option(min=1, help="Threads of each case.")] = 2,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    sim = Simulator("lake", threads=threads)
    sim.rov.release()
    sim.rov.place(PLACE_M)
    for lamp in sim.rov.lamps.values():
        lamp.on = True
    camera = sim.rov.cameras["front"]
    cases: dict[str, Callable[[], Times]] = {
        "all": lambda: timed(sim, camera, geometry_only=False),
        "geometry": lambda: timed(sim, camera, geometry_only=True),
    }
    peers = []
    with tempfile.TemporaryDirectory() as folder:
        if program := native_program("embree_bare_rays"):
            for name in ("all", "geometry"):
                file = Path(folder) / name
                write_rays(file, sim, camera, geometry_only=name == "geometry")
                for faces in ((), ("quads",)):
                    peers.append(NativePeer(program, file, threads, *faces))
                    cases["_".join(("bare", name, *faces))] = peers[-1].times_s
        seconds = alternated(cases, rounds, warm_up=True)
        for peer in peers:
            peer.close()
    frame = capture(sim, camera, geometry_only=False, measure=True)
    results = summarise(seconds, frame)
    console.print(_table(results, frame, threads))
    console.print(_tasks(frame))
    return results


def capture(sim: Simulator, camera: Camera, *, geometry_only: bool, measure: bool = False) -> Frame:
    """Capture a frame one step later, from the same pose."""
    sim.step()
    sim.rov.place(PLACE_M)
    return camera.capture(geometry_only=geometry_only, measure=measure)


def timed(sim: Simulator, camera: Camera, *, geometry_only: bool) -> Times:
    """Return the times that one frame takes, excluding the simulation step."""
    sim.step()
    sim.rov.place(PLACE_M)
    begun, processor = time.perf_counter(), time.process_time()
    camera.capture(geometry_only=geometry_only)
    return time.perf_counter() - begun, time.process_time() - processor


def summarise(seconds: dict[str, list[Times]], frame: Frame) -> dict[str, float]:
    """Return medians, and the medians of the per-round ratios."""

    def against(name: str, peer: str, clock: int = 0) -> float:
        return ratio(*([each[clock] for each in seconds[case]] for case in (name, peer)))

    results = {f"{name}_s": statistics.median(wall_s for wall_s, _ in values) for name, values in seconds.items()}
    results["frames_per_s"] = 1 / results["all_s"]
    rays = sum(frame.rays.values())
    results["rays"] = float(rays)
    results["rays_per_s"] = rays / results["all_s"]
    results["geometry_rays_per_s"] = frame.rays["primary"] / results["geometry_s"]
    if "bare_all" in seconds:
        results["against_bare"] = against("all", "bare_all")
        results["geometry_against_bare"] = against("geometry", "bare_geometry")
        results["processor_against_bare"] = against("all", "bare_all", 1)
        results["geometry_processor_against_bare"] = against("geometry", "bare_geometry", 1)
        results["against_bare_quads"] = against("all", "bare_all_quads")
        results["geometry_against_bare_quads"] = against("geometry", "bare_geometry_quads")
        results["bare_rays_per_s"] = rays / results["bare_all_s"]
    return results


def write_rays(file: Path, sim: Simulator, camera: Camera, *, geometry_only: bool) -> None:
    """Write the world's surface and the ray packets of one image for the peer."""
    packets, eye = camera.record_rays(geometry_only=geometry_only)
    vertices, triangles, _ = sim.world.surface_mesh()
    count = np.frombuffer(packets, np.uint8).size // 580
    with file.open("wb") as out:
        np.array([len(vertices), len(triangles), count], np.uint64).tofile(out)
        (vertices - eye).astype(np.float32).tofile(out)
        triangles.astype(np.uint32).tofile(out)
        out.write(packets)


def _table(results: dict[str, float], frame: Frame, threads: int) -> Table:
    size = f"{frame.info.width} x {frame.info.height}"
    title = f"front camera on the lake, {size}, {threads} threads: medians"
    table = new_table(title, "case", "ms", "million rays/s", "ratio", "goal", "met")

    def row(label: str, key: str, rays: int, ratio: str = "") -> None:
        if f"{key}_s" not in results:
            return
        value, elapsed_s = results.get(ratio), results[f"{key}_s"]
        cells = ["" if value is None else f"{value:.2f}", *goal_cells(value, GOALS.get(ratio), at_most=True)]
        table.add_row(label, f"{1e3 * elapsed_s:.1f}", f"{1e-6 * rays / elapsed_s:.1f}", *cells)

    def processor(label: str, key: str) -> None:
        if key in results:
            table.add_row(label, "", "", f"{results[key]:.2f}", "", "")

    every, primary = sum(frame.rays.values()), frame.rays["primary"]
    row("every effect, two front and two down lamps", "all", every)
    row("against Embree alone, triangles", "bare_all", every, "against_bare")
    row("against Embree alone, quads", "bare_all_quads", every, "against_bare_quads")
    processor("the same in processor time", "processor_against_bare")
    row("geometry only", "geometry", primary)
    row("against Embree alone, triangles", "bare_geometry", primary, "geometry_against_bare")
    row("against Embree alone, quads", "bare_geometry_quads", primary, "geometry_against_bare_quads")
    processor("geometry against triangles in processor time", "geometry_processor_against_bare")
    fps = results["frames_per_s"]
    table.add_section()
    table.add_row("frames per second, every effect", "", "", f"{fps:.1f}", *goal_cells(fps, GOALS["frames_per_s"]))
    return table


def _tasks(frame: Frame) -> Table:
    table = new_table("where the time of one picture goes, summed over threads", "task", "ms")
    for name, elapsed_s in sorted(frame.task_s.items(), key=lambda item: -item[1]):
        table.add_row(name, f"{1e3 * elapsed_s:.1f}")
    table.add_section()
    for kind, count in frame.rays.items():
        table.add_row(f"{kind} rays", f"{count:,}")
    return table
