"""Frames per second of the ROV's front camera on the lake, compared with bare Embree casting the same rays.

All cases alternate within one run, so that other load on the machine affects them equally; results are medians over the
rounds, and ratios are computed per round, of wall time and of all threads' processor time; only the latter mean much on
a busy machine. Each frame is at a different time, so that waves, ripples and noise are recomputed. The native peer
builds its tree from the same triangles, receives the same sixteen-ray packets that the images cast (primary, shadow and
shaft rays) and casts them on as many threads. With the terrain as quads, as in our own tree, the peer is faster; that
rate is also printed.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from uwsim import Simulator, _core
from uwsim.instruments.cameras import Camera, Frame

console = Console()

PLACE_M = (-67.0, -52.0, -26.0)  # two metres above the bed, in front of a gate
GOALS = {"frames_per_s": 60.0, "against_bare": 1.6, "geometry_against_bare": 1.15}
Times = tuple[float, float]  # wall and processor time of a case [s]


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often to measure each case; medians are reported.")] = 15,
    threads: Annotated[int, typer.Option(min=1, help="Threads of each case.")] = 2,
    json_file: Annotated[Path | None, typer.Option("--json", help="Also write the values to this file.")] = None,
) -> None:
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
        if (program := bare_rays_program()) is not None:
            for name in ("all", "geometry"):
                file = Path(folder) / name
                write_rays(file, sim, camera, geometry_only=name == "geometry")
                for faces in ((), ("quads",)):
                    peer = BareEmbree([str(program), str(file), str(threads), *faces])
                    peers.append(peer)
                    cases["_".join(("bare", name, *faces))] = peer.times_s
        else:
            console.print("skipping Embree alone: embree_bare_rays is not installed with the package (run tools/setup)")
        seconds: dict[str, list[Times]] = {name: [] for name in cases}
        for k in range(rounds + 1):
            with console.status(f"round {k} of {rounds}"):
                for name, measure in cases.items():
                    elapsed = measure()
                    if k > 0:  # the first round warms up
                        seconds[name].append(elapsed)
        for peer in peers:
            peer.close()
    frame = capture(sim, camera, geometry_only=False, measure=True)
    figures = summarise(seconds, frame)
    console.print(_table(figures, frame, threads))
    console.print(_tasks(frame))
    if json_file is not None:
        json_file.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


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

    def ratio(name: str, peer: str, clock: int = 0) -> float:
        return statistics.median(a[clock] / b[clock] for a, b in zip(seconds[name], seconds[peer], strict=True))

    figures = {f"{name}_s": statistics.median(wall_s for wall_s, _ in values) for name, values in seconds.items()}
    figures["frames_per_s"] = 1 / figures["all_s"]
    rays = sum(frame.rays.values())
    figures["rays"] = float(rays)
    figures["rays_per_s"] = rays / figures["all_s"]
    figures["geometry_rays_per_s"] = frame.rays["primary"] / figures["geometry_s"]
    if "bare_all" in seconds:
        figures["against_bare"] = ratio("all", "bare_all")
        figures["geometry_against_bare"] = ratio("geometry", "bare_geometry")
        figures["processor_against_bare"] = ratio("all", "bare_all", 1)
        figures["geometry_processor_against_bare"] = ratio("geometry", "bare_geometry", 1)
        figures["against_bare_quads"] = ratio("all", "bare_all_quads")
        figures["geometry_against_bare_quads"] = ratio("geometry", "bare_geometry_quads")
        figures["bare_rays_per_s"] = rays / figures["bare_all_s"]
    return figures


def bare_rays_program() -> Path | None:
    """Return the path of the native peer, which is installed with the compiled module, or None if it is missing."""
    program = Path(_core.__file__).parent / "bench" / "native" / "embree_bare_rays"
    return program if program.is_file() else None


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


class BareEmbree:
    """The peer's process, which casts all rays of one image on request."""

    def __init__(self, command: list[str]) -> None:
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def processor_s(self) -> float:
        """Cast all rays and return the seconds of processor time."""
        return self.times_s()[1]

    def times_s(self) -> Times:
        """Cast all rays and return wall and processor time."""
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        wall_s, processor_s = map(float, self._process.stdout.readline().split())
        return wall_s, processor_s

    def close(self) -> None:
        """Stop the process."""
        self._process.communicate()


def _table(figures: dict[str, float], frame: Frame, threads: int) -> Table:
    size = f"{frame.info.width} x {frame.info.height}"
    title = f"front camera on the lake, {size}, {threads} threads: medians"
    table = Table(title=title, title_justify="left")
    table.add_column("case")
    for column in ("ms", "million rays/s", "ratio", "goal", "met"):
        table.add_column(column, justify="right")

    def row(label: str, key: str, rays: int, ratio: str = "") -> None:
        if f"{key}_s" not in figures:
            return
        goal, value = ["", "", ""], figures.get(ratio)
        if value is not None:
            goal[0] = f"{value:.2f}"
        if value is not None and ratio in GOALS:
            goal[1:] = [f"{GOALS[ratio]:g}", "[green]yes[/]" if value <= GOALS[ratio] else "[red]no[/]"]
        elapsed_s = figures[f"{key}_s"]
        table.add_row(label, f"{1e3 * elapsed_s:.1f}", f"{1e-6 * rays / elapsed_s:.1f}", *goal)

    def processor(label: str, key: str) -> None:
        if key in figures:
            table.add_row(label, "", "", f"{figures[key]:.2f}", "", "")

    every, primary = sum(frame.rays.values()), frame.rays["primary"]
    row("every effect, two front and two down lamps", "all", every)
    row("against Embree alone, triangles", "bare_all", every, "against_bare")
    row("against Embree alone, quads", "bare_all_quads", every, "against_bare_quads")
    processor("the same in processor time", "processor_against_bare")
    row("geometry only", "geometry", primary)
    row("against Embree alone, triangles", "bare_geometry", primary, "geometry_against_bare")
    row("against Embree alone, quads", "bare_geometry_quads", primary, "geometry_against_bare_quads")
    processor("geometry against triangles in processor time", "geometry_processor_against_bare")
    fps = figures["frames_per_s"]
    met = "[green]yes[/]" if fps >= GOALS["frames_per_s"] else "[red]no[/]"
    table.add_section()
    table.add_row("frames per second, every effect", "", "", f"{fps:.1f}", f"{GOALS['frames_per_s']:g}", met)
    return table


def _tasks(frame: Frame) -> Table:
    table = Table(title="where the time of one picture goes, summed over threads", title_justify="left")
    table.add_column("task")
    table.add_column("ms", justify="right")
    for name, elapsed_s in sorted(frame.task_s.items(), key=lambda item: -item[1]):
        table.add_row(name, f"{1e3 * elapsed_s:.1f}")
    table.add_section()
    for kind, count in frame.rays.items():
        table.add_row(f"{kind} rays", f"{count:,}")
    return table


if __name__ == "__main__":
    app = typer.Typer(add_completion=False)
    app.command()(main)
    app(prog_name="uwsim bench camera")
