"""Milliseconds to insert a ping, bricks compared with stock OctoMap, and the memory of both.

The workload is a survey of the packaged lake's bed: 8 m above its hills, a ping every 10 cm, ranges from the true
surfaces; a beam without an echo marks voxels free up to the sonar's range. The cases alternate within one run, each
with its own map and the same pings, so that other load on the machine affects all equally; medians over the rounds are
reported. One core is measured by processor time, two cores by wall time, stock OctoMap by both. Stock OctoMap takes
seconds; bricks take milliseconds, too short for an idle core to reach its full clock rate. Each round therefore takes
the median of several consecutive brick insertions, each into a new map.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
import typer
from _harness import alternated, console, goal_cells, native_program, new_table, ratio
from numpy.typing import NDArray
from rich.table import Table

from uwsim import _core
from uwsim.mapping import OccupancyMap
from uwsim.scenario import build_world, load

ALTITUDE_M, SPACING_M, START_M = 8.0, 0.1, (-60.0, 0.0)
NO_ECHO_M = 5.0  # a beam without an echo becomes a point this far beyond the range
BATCH = 32  # scans per call
REPEATS = 9  # brick insertions per stock OctoMap insertion
MEMORY_PINGS = 600
MEMORY_GOAL = 1 / 3


@dataclass(frozen=True)
class Workload:
    """A sonar, and for each resolution [m] the number of pings that stock OctoMap inserts in a few seconds."""

    beams: int
    fov_deg: float
    range_m: float
    tilt_deg: float
    pings: dict[float, int]


WORKLOADS = {
    "A": Workload(1025, 170, 95, 7, {0.2: 60, 0.5: 100}),
    "B": Workload(513, 85, 55, 10, {0.2: 100, 0.5: 200}),
    "D": Workload(1025, 170, 95, 45, {0.2: 60, 0.5: 200}),
}
# Ratios to the time of stock OctoMap in eager mode: one core, two cores. They are 0.8 times those of the first
# prototype.
GOALS = {
    "A 0.2": (256, 402),
    "A 0.5": (50, 75),
    "B 0.2": (83, 137),
    "B 0.5": (24, 26),
    "D 0.2": (86, 133),
    "D 0.5": (25, 35),
}
PORTABLE_GOAL = 7.0


@dataclass(frozen=True)
class Scans:
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
        ends = np.cumsum(self.counts)
        with path.open("wb") as file:
            for count, end, origin in zip(self.counts, ends, self.origins_m, strict=True):
                file.write(np.int32(count).tobytes() + origin.astype(np.float32).tobytes())
                file.write(self.points_m[end - count : end].tobytes())


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often each case is measured; medians are reported.")] = 3,
    memory: Annotated[bool, typer.Option(help="Also measure peak memory: minutes with stock OctoMap.")] = False,
    only: Annotated[str, typer.Option(help="Only this workload: A, B or D.")] = "",
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
    chosen = {name: work for name, work in WORKLOADS.items() if only in ("", name)}
    seabed = Seabed()
    results: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, work in chosen.items():
            for resolution_m, pings in work.pings.items():
                scans = seabed.scans(work, pings)
                cases = make_cases(scans, resolution_m, Path(folder), peers)
                results[f"{name} {resolution_m:g}"] = measure(f"{name} {resolution_m:g}", cases, rounds)
    console.print(_table(results))
    if memory and "A" in chosen:
        results["memory"] = peak_memory(seabed.scans(WORKLOADS["A"], MEMORY_PINGS), 0.2)
        console.print(_memory_line(results["memory"]))
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


@dataclass(frozen=True)
class Cost:
    """Time of one ping [ms]."""

    processor_ms: float
    wall_ms: float


Case = Callable[[], Cost]


def make_cases(
    scans: Scans, resolution_m: float, folder: Path, peers: Mapping[str, Path] = MappingProxyType({})
) -> dict[str, Case]:
    """Return the cases available on this machine, by name. peers: further programs."""

    def bricks(instruction_set: str = "best", threads: int = 1, batch: int = BATCH) -> Case:
        return lambda: median([insert(scans, resolution_m, batch, threads, instruction_set) for _ in range(REPEATS)])

    cases: dict[str, Case] = {}
    path = folder / "scans.bin"
    scans.write(path)
    if program := native_program("octomap_insert"):
        for mode in ("eager", "lazy"):
            cases[f"stock_{mode}"] = lambda mode=mode: native(program, path, resolution_m, scans.range_m, mode)
    for name, own in peers.items():
        cases[name] = lambda own=own: native(own, path, resolution_m, scans.range_m, "eager")
    if (peer := pyoctomap_peer(scans, resolution_m)) is not None:
        cases["pyoctomap"] = peer
    cases["bricks_1"] = bricks()
    cases["bricks_2"] = bricks(threads=2)
    cases["one_by_one"] = lambda: median([insert_one_by_one(scans, resolution_m) for _ in range(REPEATS)])
    cases["portable"] = bricks("portable")
    return cases


def measure(name: str, cases: dict[str, Case], rounds: int) -> dict[str, float]:
    """Return medians of the times, and of their ratios to stock eager in the same round."""
    costs = alternated(cases, rounds, what=f"{name} m: ")
    results = {}
    for case in cases:
        clock = attrgetter("wall_ms" if case == "bricks_2" else "processor_ms")
        times_ms = list(map(clock, costs[case]))
        results[f"{case}_ms"] = statistics.median(times_ms)
        if "stock_eager" in cases and case != "stock_eager":
            results[f"{case}_ratio"] = ratio(map(clock, costs["stock_eager"]), times_ms)
    return results


def median(costs: list[Cost]) -> Cost:
    """Return the medians of processor and wall time."""
    return Cost(statistics.median(c.processor_ms for c in costs), statistics.median(c.wall_ms for c in costs))


def insert(scans: Scans, resolution_m: float, batch: int, threads: int, instruction_set: Any) -> Cost:
    """Insert in batches with the brick engine."""
    batches = scans.batches(batch)
    occupancy = OccupancyMap(resolution_m, instruction_set=instruction_set)
    with Stopwatch(len(scans.counts)) as watch:
        for points_m, counts, origins_m in batches:
            occupancy.insert_scans(points_m, counts, origins_m, scans.range_m, threads)
    return watch.cost


def insert_one_by_one(scans: Scans, resolution_m: float) -> Cost:
    """Insert with the brick engine, one call per ping."""
    batches = scans.batches(1)
    occupancy = OccupancyMap(resolution_m)
    with Stopwatch(len(scans.counts)) as watch:
        for points_m, _, origins_m in batches:
            occupancy.insert_scan(points_m, origins_m[0], scans.range_m)
    return watch.cost


class Stopwatch:
    """Measure the processor and wall time of a block, per ping."""

    def __init__(self, pings: int) -> None:
        self._pings = pings
        self.cost = Cost(0.0, 0.0)

    def __enter__(self) -> Stopwatch:
        self._start = time.process_time(), time.perf_counter()
        return self

    def __exit__(self, *error: object) -> None:
        scale = 1e3 / self._pings
        self.cost = Cost(scale * (time.process_time() - self._start[0]), scale * (time.perf_counter() - self._start[1]))


def native(program: Path, path: Path, resolution_m: float, range_m: float, mode: str) -> Cost:
    """Insert with stock OctoMap, or a peer, in a separate process."""
    command = [program, path, str(resolution_m), str(range_m), mode]
    processor_s, wall_s = map(float, subprocess.run(command, check=True, capture_output=True, text=True).stdout.split())
    return Cost(1e3 * processor_s, 1e3 * wall_s)


def pyoctomap_peer(scans: Scans, resolution_m: float) -> Case | None:
    """Return a case for OctoMap through pyoctomap, its best-known Python wheel, or None if it is not installed."""
    try:
        import pyoctomap  # type: ignore[import-not-found, unused-ignore]
    except ImportError:
        return None

    def run() -> Cost:
        tree = pyoctomap.OcTree(resolution_m)
        batches = [(points.astype(np.float64), origins[0]) for points, _, origins in scans.batches(1)]
        with Stopwatch(len(scans.counts)) as watch:
            for points_m, origin_m in batches:
                tree.insertPointCloud(points_m, origin_m, scans.range_m, False)
        return watch.cost

    return run


MEMORY_SCRIPT = """
import sys
import numpy as np
from uwsim.mapping import OccupancyMap

folder, engine, resolution_m, range_m, batch = sys.argv[1], sys.argv[2], *map(float, sys.argv[3:])
points, counts, origins = (np.load(f"{folder}/{name}.npy") for name in ("points", "counts", "origins"))

def peak_kb():
    return int(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))

occupancy = OccupancyMap(resolution_m, engine=engine)
open("/proc/self/clear_refs", "w").write("5")  # resets the peak
before = peak_kb()
ends = np.cumsum(counts)
for first in range(0, len(counts), int(batch)):
    cut = slice(first, min(first + int(batch), len(counts)))
    rows = slice(ends[first] - counts[first], ends[cut.stop - 1])
    occupancy.insert_scans(points[rows], counts[cut], origins[cut], range_m)
print(peak_kb() - before)
"""


def peak_memory(scans: Scans, resolution_m: float) -> dict[str, float]:
    """Return the peak growth of a process while all scans are inserted [MB]."""
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, array in (("points", scans.points_m), ("counts", scans.counts), ("origins", scans.origins_m)):
            np.save(Path(folder) / f"{name}.npy", array)
        for engine in ("octomap", "bricks"):
            with console.status(f"peak memory of {engine}"):
                arguments = [folder, engine, str(resolution_m), str(scans.range_m), str(BATCH)]
                command = [sys.executable, "-c", MEMORY_SCRIPT, *arguments]
                said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            results[f"{engine}_mb"] = int(said) / 1024
    results["share"] = results["bricks_mb"] / results["octomap_mb"]
    return results


def _table(results: dict[str, dict[str, float]]) -> Table:
    columns = ("workload", "voxel m", "engine", "ms a ping", "times as fast", "goal", "met")
    table = new_table("Inserting a ping: medians", *columns, texts=3)
    labels = {
        "stock_eager": "stock OctoMap, eager",
        "stock_lazy": "stock OctoMap, lazy",
        "pyoctomap": "pyoctomap",
        "bricks_1": f"bricks, one core, {BATCH} a call",
        "bricks_2": f"bricks, two cores, {BATCH} a call",
        "one_by_one": "bricks, one core, one a call",
        "portable": "bricks, portable kernels",
    }
    for name, row in results.items():
        goals = {"bricks_1": GOALS[name][0], "bricks_2": GOALS[name][1], "portable": PORTABLE_GOAL}
        timed = [key.removesuffix("_ms") for key in row if key.endswith("_ms")]
        for case, label in (labels | {case: case for case in timed if case not in labels}).items():
            if f"{case}_ms" in row:
                times = row.get(f"{case}_ratio")
                cells = ["" if times is None else f"{times:,.3g}", *goal_cells(times, goals.get(case))]
                table.add_row(*name.split(), label, f"{row[f'{case}_ms']:,.3g}", *cells)
        table.add_section()
    return table


def _memory_line(memory: dict[str, float]) -> str:
    met = "[green]met[/]" if memory["share"] <= MEMORY_GOAL else "[red]missed[/]"
    return (
        f"peak memory of A at 0.2 m over {MEMORY_PINGS} pings: stock {memory['octomap_mb']:.1f} MB, "
        f"bricks {memory['bricks_mb']:.1f} MB, {memory['share']:.2f} of it (goal 1/3: {met})"
    )
