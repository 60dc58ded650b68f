"""Milliseconds to insert a ping, bricks compared with stock OctoMap, and the memory of both.

The workload is a survey of the packaged lake's bed: 8 m above its hills, a ping every 10 cm, tilted by 30 degrees as
in the packaged surveys; a beam without an echo marks voxels free up to the sonar's range. One core is measured by
processor time, two cores by wall time. Bricks are too fast for an idle core to reach its full clock rate: each round
takes the median of several insertions.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from _harness import Rounds, alternated, child, console, native_program, peak_mb, ratio, result_of, show, trimmed_mb
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping import OccupancyMap
from uwsim.scenario import build_world, load

ALTITUDE_M, SPACING_M, START_M = 8.0, 0.1, (-60.0, 0.0)
NO_ECHO_M = 5.0  # a beam without an echo becomes a point this far beyond the range
BATCH = 32  # scans per call
REPEATS = 9  # brick insertions per stock OctoMap insertion
MEMORY_PINGS = 600


class Workload(NamedTuple):
    """A sonar, and for each resolution [m] the number of pings that stock OctoMap inserts in a few seconds."""

    beams: int
    fov_deg: float
    range_m: float
    tilt_deg: float
    pings: dict[float, int]


WORKLOADS = {
    "A": Workload(1025, 170, 95, 30, {0.2: 60, 0.5: 200}),
    "B": Workload(513, 85, 55, 30, {0.2: 100, 0.5: 200}),
}


class Scans(NamedTuple):
    """Successive pings: points_m (n, 3) float32, counts (m,), origins_m (m, 3)."""

    points_m: NDArray[np.float32]
    counts: NDArray[np.int64]
    origins_m: NDArray[np.float64]
    range_m: float

    def batches(self, size: int) -> list[tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.float64]]]:
        """Return the scans in batches of `size`, without copies."""
        ends = np.cumsum(self.counts)
        starts = ends - self.counts
        cuts = [slice(first, min(first + size, len(ends))) for first in range(0, len(ends), size)]
        return [
            (self.points_m[starts[cut.start] : ends[cut.stop - 1]], self.counts[cut], self.origins_m[cut])
            for cut in cuts
        ]

    def write(self, path: Path) -> None:
        """Write the scans in the form that octomap_insert reads."""
        with path.open("wb") as file:
            for points_m, counts, origins_m in self.batches(1):
                file.write(np.int32(counts[0]).tobytes() + origins_m[0].astype(np.float32).tobytes())
                file.write(points_m.tobytes())


def main(
    rounds: Rounds = 3,
    memory: Annotated[bool, typer.Option(help="Also measure peak memory: minutes with stock OctoMap.")] = False,
    only: Annotated[str, typer.Option(help="Only this workload: A or B.")] = "",
    peer: Annotated[
        list[Path] | None,
        typer.Option(help="A program with octomap_insert's usage that inserts with another library; may be repeated."),
    ] = None,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    if only not in ("", *WORKLOADS):
        raise ValueError(f"--only {only}: must be one of {', '.join(WORKLOADS)}")
    peers = {program.name: program.resolve() for program in peer or ()}
    for program in peers.values():
        if not os.access(program, os.X_OK) or not program.is_file():
            raise ValueError(f"--peer {program}: must be a program")
    seabed = Seabed()
    results: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in [only] if only else WORKLOADS:
            for resolution_m, pings in WORKLOADS[name].pings.items():
                cases = make_cases(seabed.scans(WORKLOADS[name], pings), resolution_m, Path(folder), peers)
                title = f"{name} {resolution_m:g}"
                results[title] = measure(title, cases, rounds)
                goals = {"portable_ratio": ">= 7"}
                show(f"a ping of {title} m, {BATCH} a call: ms, and times as fast", results[title], goals)
    if memory and only in ("", "A"):
        results["memory"] = peak_memory(WORKLOADS["A"], MEMORY_PINGS, 0.2)
        show(f"peak memory of A at 0.2 m over {MEMORY_PINGS} pings", results["memory"], {"share": f"<= {1 / 3}"})
    return results


class Seabed:
    """Scans of a multibeam sonar over the lake's hills."""

    def __init__(self) -> None:
        self._world = build_world(load("lake"))
        self._scene = _core.RayScene(self._world)

    def scans(self, work: Workload, pings: int) -> Scans:
        """Return the first pings of the track."""
        angles = np.radians(np.linspace(-work.fov_deg / 2, work.fov_deg / 2, work.beams))
        tilt = np.radians(work.tilt_deg)
        directions = np.column_stack([np.cos(angles) * np.cos(tilt), np.sin(angles), -np.cos(angles) * np.sin(tilt)])
        clouds, origins = [], []
        for ping in range(pings):
            x, y = START_M[0] + SPACING_M * ping, START_M[1]
            origin = np.array([x, y, float(self._world.height_at([[x, y]])[0]) + ALTITUDE_M])
            ranges = self._scene.cast(origin[None], directions, work.range_m).ranges_m.astype(float)
            ranges[~np.isfinite(ranges)] = work.range_m + NO_ECHO_M
            clouds.append((origin + directions * ranges[:, None]).astype(np.float32))
            origins.append(origin)
        return Scans(np.concatenate(clouds), np.full(pings, work.beams), np.array(origins), work.range_m)


Cost = tuple[float, float]
"""Processor and wall time of one ping [ms]."""
Insertion = Callable[[], Cost]


def make_cases(
    scans: Scans, resolution_m: float, folder: Path, peers: Mapping[str, Path] = MappingProxyType({})
) -> dict[str, Insertion]:
    """Return the cases available on this machine, by name. peers: further programs."""
    path = folder / "scans.bin"
    scans.write(path)

    def native(program: Path, mode: str) -> Cost:
        command = [program, path, str(resolution_m), str(scans.range_m), mode]
        output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        processor_s, wall_s = map(float, output.split())
        return 1e3 * processor_s, 1e3 * wall_s

    def bricks(instruction_set: Any = "best", threads: int = 1, size: int = BATCH) -> Cost:
        batches, costs = scans.batches(size), []
        for _ in range(REPEATS):
            occupancy = OccupancyMap(resolution_m, instruction_set=instruction_set)
            processor_s, wall_s = time.process_time(), time.perf_counter()
            for points_m, counts, origins_m in batches:
                if size == 1:
                    occupancy.insert_scan(points_m, origins_m[0], scans.range_m)
                else:
                    occupancy.insert_scans(points_m, counts, origins_m, scans.range_m, threads)
            costs.append((time.process_time() - processor_s, time.perf_counter() - wall_s))
        processor_s, wall_s = (1e3 * statistics.median(times) / len(scans.counts) for times in zip(*costs, strict=True))
        return processor_s, wall_s

    cases: dict[str, Insertion] = {}
    if stock := native_program("octomap_insert"):
        cases = {f"stock_{mode}": lambda mode=mode: native(stock, mode) for mode in ("eager", "lazy")}
    cases |= {name: lambda own=own: native(own, "eager") for name, own in peers.items()}
    return cases | {
        "bricks_1": bricks,
        "bricks_2": lambda: bricks(threads=2),
        "one_by_one": lambda: bricks(size=1),
        "portable": lambda: bricks("portable"),
    }


def measure(name: str, cases: dict[str, Insertion], rounds: int) -> dict[str, float]:
    """Return medians of the times, and of their ratios to stock eager in the same round."""
    costs = alternated(cases, rounds, what=f"{name} m: ")
    results = {}
    for case in cases:
        clock = int(case == "bricks_2")
        times_ms = [cost[clock] for cost in costs[case]]
        results[f"{case}_ms"] = statistics.median(times_ms)
        if "stock_eager" in cases and case != "stock_eager":
            results[f"{case}_ratio"] = ratio((cost[clock] for cost in costs["stock_eager"]), times_ms)
    return results


def peak_memory(work: Workload, pings: int, resolution_m: float) -> dict[str, float]:
    """Return the peak growth of a process of its own while all scans are inserted [MB]."""
    results = {}
    for engine in ("octomap", "bricks"):
        with console.status(f"peak memory of {engine}"):
            process = child(__file__, engine, pings, resolution_m, *work[:4])
            results[f"{engine}_mb"] = float(result_of(process, limit_s=None))
    return results | {"share": results["bricks_mb"] / results["octomap_mb"]}


def growth_mb(engine: Any, pings: int, resolution_m: float, beams: int, *sonar: float) -> float:
    """Return the peak growth of this process while all scans are inserted [MB]."""
    scans = Seabed().scans(Workload(beams, *sonar, {}), pings)
    occupancy = OccupancyMap(resolution_m, engine=engine)
    trimmed_mb()
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak
    before_mb = peak_mb()
    for points_m, counts, origins_m in scans.batches(BATCH):
        occupancy.insert_scans(points_m, counts, origins_m, scans.range_m)
    return peak_mb() - before_mb


if __name__ == "__main__":
    engine, pings, resolution, beams, *sonar = sys.argv[1:]
    print(growth_mb(engine, int(pings), float(resolution), int(beams), *map(float, sonar)))
