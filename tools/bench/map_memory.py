"""Time and memory of a map over ten kilometres of track, with and without a memory limit.

A multibeam sonar with the widest fan is towed to and fro, 8 m above hills of noise; its pings are cast and inserted.
Each case runs in a separate process; the system reports the memory of the process. Both maps must write the same bytes.
"""

from __future__ import annotations

import hashlib
import json
import resource
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import PlotFile, child, console, new_table, result_of
from numpy.typing import NDArray
from rich.table import Table

from uwsim import _core
from uwsim.figures.style import ACCENT, INK, add_legend, label_axes, new_figure, save_figure
from uwsim.mapping import OccupancyMap

ALTITUDE_M, TILT_DEG, BEAMS, FAN_DEG, RANGE_M = 8.0, 7.0, 1025, 170.0, 95.0
LEG_M, LEG_SPACING_M = 1000.0, 80.0
BATCH = 16
SAMPLE_M = 100.0


def main(
    track_km: Annotated[float, typer.Option(min=0.1, help="Length of the track.")] = 10.0,
    resolution: Annotated[float, typer.Option(help="Edge of a voxel [m].")] = 0.2,
    step: Annotated[float, typer.Option(help="Distance between two pings [m].")] = 0.5,
    limit_mb: Annotated[float, typer.Option(help="Memory limit of the second map [MB].")] = 200.0,
    threads: Annotated[int, typer.Option(min=1)] = 2,
    plot: PlotFile = None,
) -> dict[str, Any]:
    """Fly the track twice, compare the maps, print the results."""
    cases = {}
    for name, limit in (("no limit", 0.0), (f"limit {limit_mb:g} MB", limit_mb)):
        with console.status(name):
            cases[name] = result_of(child(__file__, track_km, resolution, step, limit, threads), limit_s=None)
    console.print(_table(cases))
    if plot is not None:
        draw(plot, cases)
    first, second = cases.values()
    for suffix in ("ot", "bt"):
        if first[suffix] != second[suffix]:
            raise SystemExit(f"the .{suffix} of the two maps differ")
        console.print(f"the .{suffix} of both are the same bytes")
    return cases


def hills(width_m: float, height_m: float, rng: np.random.Generator) -> _core.World:
    """Return a bed of smooth noise about 30 m deep, with hills a few metres high every few tens of metres."""
    x, y = np.arange(-150.0, width_m + 150.0), np.arange(-150.0, height_m + 150.0)
    heights = np.full((len(y), len(x)), -30.0)
    for wave_m, size_m in ((160.0, 3.0), (60.0, 1.2), (23.0, 0.4)):
        for heading in rng.uniform(0.0, 2.0 * np.pi, 4):
            along = np.cos(heading) * x[None, :] + np.sin(heading) * y[:, None]
            heights += size_m / 2.0 * np.sin(2.0 * np.pi * along / wave_m + rng.uniform(0.0, 2.0 * np.pi))
    world = _core.World()
    world.set_terrain(heights.astype(np.float32), 1.0, (float(x[0]), float(y[0])))
    return world


def track(track_m: float, step_m: float) -> NDArray[np.float64]:
    """Return the pings of a lawn-mower track, (n, 3): x, y and the heading along x, +1 or -1."""
    along = np.arange(0.0, track_m, step_m)
    leg, within = np.divmod(along, LEG_M)
    forth = leg % 2 == 0
    return np.column_stack([np.where(forth, within, LEG_M - within), leg * LEG_SPACING_M, np.where(forth, 1.0, -1.0)])


def fan() -> NDArray[np.float64]:
    """Return the directions of a fan across x, tilted forward, (beams, 3)."""
    angles, tilt = np.radians(np.linspace(-FAN_DEG / 2.0, FAN_DEG / 2.0, BEAMS)), np.radians(TILT_DEG)
    down = np.cos(angles)
    return np.column_stack([down * np.sin(tilt), np.sin(angles), -down * np.cos(tilt)])


def fly(track_km: float, resolution_m: float, step_m: float, limit_mb: float | None, threads: int) -> dict[str, Any]:
    """Fly the track with one map; return its time and memory."""
    pings = track(1000.0 * track_km, step_m)
    legs = 1 + int(pings[-1, 1] // LEG_SPACING_M)
    world = hills(LEG_M, legs * LEG_SPACING_M, np.random.default_rng(7))
    scene, beams = _core.RayScene(world), fan()
    occupancy = OccupancyMap(resolution_m, memory_limit_mb=limit_mb)
    at_start_mb = rss_mb()
    samples = [(0.0, 0.0, 0.0, at_start_mb)]
    rays_s = map_s = 0.0
    starts = range(0, len(pings), BATCH)
    for first in starts:
        started = time.perf_counter()
        points, origins = [], []
        for x, y, heading in pings[first : first + BATCH]:
            origin = np.array([x, y, float(world.height_at([[x, y]])[0]) + ALTITUDE_M])
            directions = beams * (heading, 1.0, 1.0)
            ranges_m = scene.cast(origin[None, :], directions, RANGE_M).ranges_m
            hit = np.isfinite(ranges_m)
            points.append((origin + directions[hit] * ranges_m[hit, None]).astype(np.float32))
            origins.append(origin)
        cast = time.perf_counter()
        counts = [len(part) for part in points]
        occupancy.insert_scans(np.concatenate(points), counts, np.array(origins), RANGE_M + 1.0, threads)
        rays_s, map_s = rays_s + cast - started, map_s + time.perf_counter() - cast
        distance_m = min(first + BATCH, len(pings)) * step_m
        if distance_m // SAMPLE_M != samples[-1][0] // SAMPLE_M or first == starts[-1]:
            samples.append((distance_m, rays_s, map_s, rss_mb()))
    flown_mb = peak_mb()
    statistics = occupancy.statistics()
    written = write(occupancy)
    return {
        "pings": len(pings),
        "samples": samples,
        "map_peak_mb": flown_mb - at_start_mb,
        "peak_mb": flown_mb,
        "map_s": map_s,
        "rays_s": rays_s,
        "evictions": statistics.evictions,
        "occupied": statistics.occupied_voxels,
        "free": statistics.free_voxels,
        **written,
    }


def write(occupancy: OccupancyMap) -> dict[str, Any]:
    """Write the map files; return their digests, and the time and memory used."""
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for suffix in ("ot", "bt"):
            path, started = Path(folder) / f"map.{suffix}", time.perf_counter()
            occupancy.write(path)
            found[f"{suffix}_s"] = time.perf_counter() - started
            found[f"{suffix}_mb"] = path.stat().st_size / 1e6
            with path.open("rb") as file:
                found[suffix] = hashlib.file_digest(file, "sha256").hexdigest()
            found[f"peak_after_{suffix}_mb"] = peak_mb()
    return found


def rss_mb() -> float:
    """Return the resident memory of this process."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6


def peak_mb() -> float:
    """Return the peak resident memory of this process."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


def _table(cases: dict[str, dict[str, Any]]) -> Table:
    first = next(iter(cases.values()))
    title = f"{first['pings']:,} pings of {BEAMS} beams over {first['samples'][-1][0] / 1000:g} km"
    table = new_table(title, "", *cases)
    rows = (
        ("map, s", "map_s", ".1f"), ("rays, s", "rays_s", ".1f"), ("peak of the process, MB", "peak_mb", ",.0f"),
        ("of it while flying, MB", "map_peak_mb", ",.0f"), ("peak after the .ot, MB", "peak_after_ot_mb", ",.0f"),
        ("peak after the .bt, MB", "peak_after_bt_mb", ",.0f"), ("writing the .ot, s", "ot_s", ".1f"),
        ("writing the .bt, s", "bt_s", ".1f"), (".ot, MB", "ot_mb", ",.1f"), (".bt, MB", "bt_mb", ",.1f"),
        ("evicted chunks", "evictions", ",d"), ("occupied voxels", "occupied", ",d"),
        ("free voxels", "free", ",d"),
    )  # fmt: skip
    for name, key, form in rows:
        table.add_row(name, *(format(case[key], form) for case in cases.values()))
    return table


def draw(path: Path, cases: dict[str, dict[str, Any]]) -> None:
    """Plot the map's time and the process's memory against distance."""
    figure = new_figure(10.0, 4.6)
    figure.subplots_adjust(left=0.08, right=0.98, top=0.9, bottom=0.27, wspace=0.22)
    per_100_m, memory = figure.subplots(1, 2)
    label_axes(per_100_m, "time of the map", "distance [km]", "seconds in 100 m of track")
    label_axes(memory, "memory of the process", "distance [km]", "resident [MB]")
    for (name, case), colour in zip(cases.items(), (INK, ACCENT), strict=True):
        samples = np.array(case["samples"])
        rates = [(b[2] - a[2]) / (b[0] - a[0]) * 100.0 for a, b in pairwise(case["samples"])]
        per_100_m.plot(samples[1:, 0] / 1000.0, rates, color=colour, label=name, linewidth=1.2)
        memory.plot(samples[:, 0] / 1000.0, samples[:, 3], color=colour, label=name, linewidth=1.2)
    for axes in (per_100_m, memory):
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(left=0.0)
        add_legend(axes, 2)
    save_figure(figure, path)


if __name__ == "__main__":
    *lengths, one_limit_mb, one_threads = map(float, sys.argv[1:])
    print(json.dumps(fly(*lengths, one_limit_mb or None, int(one_threads))))
