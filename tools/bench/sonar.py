"""Pings per second on the lake, compared with the rays alone (the limit), Bullet, pybullet and trimesh with embreex.

All cases alternate within one run, so that other load affects all of them equally; results are medians over the rounds,
and medians of per-round ratios. Measured in single-thread CPU time, except multithreaded ping_batch, which is measured
in wall time.

All cases ping from the same poses along the survey's lines. From scattered poses, each ping waits until another part of
the ray tree has been loaded; this is reported separately. The limit is the best rate of Embree's ray packets.
"""

from __future__ import annotations

import struct
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import (
    NativePeer,
    PlotFile,
    alternated,
    console,
    goal_cells,
    medians,
    native_program,
    new_table,
    ratio,
    spent_s,
)
from numpy.typing import NDArray
from rich.table import Table
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.figures.style import new_figure, save_figure
from uwsim.scenario import load

SONAR_MODEL = 3  # 1,025 beams to 95 m
ALTITUDE_M = 8.0
AREA_M = ((-104.0, 56.0), (-80.0, 24.0))  # the lake's survey
LINES_APART_M = 13.0
PINGS_APART_M = 0.3
SIZES = (10_000, 31_623, 100_000, 316_228, 1_000_000, 3_162_278, 10_000_000)
GROWTH = {"_again": "one place again, all in the caches", "": "along survey lines", "_scattered": "scattered places"}
LIMITS = {"quads": ("coherent", "quads"), "triangles": ("coherent",), "incoherent": ("quads",)}
GOALS = {
    "ping/limit": 0.8,
    "ping_scattered/limit_scattered": 0.8,
    "batch_2/batch_1": 1.7,
    "ping/bullet": 10.0,
    "ping/pybullet": 10.0,
    "ping/trimesh": 2.0,
    "ping/physics": 12.0,  # maximum
    "physics/physics_bent": 2.5,  # maximum
    "physics/physics_multipath": 2.0,  # maximum
}


@dataclass(frozen=True)
class Heads:
    """The poses of the vehicle and of the sonar head (n, 4, 4) at each ping, and the fan's angles (beams,)."""

    positions_world_m: NDArray[np.float64]
    orientations_xyzw: NDArray[np.float64]
    world_from_body: NDArray[np.float64]
    world_from_sonar: NDArray[np.float64]
    angles_rad: NDArray[np.float64]
    range_m: float

    @property
    def rays(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return origins and directions (n, beams, 3) in the world frame."""
        table = np.column_stack([np.cos(self.angles_rad), np.sin(self.angles_rad)])
        directions = np.einsum("nij,bj->nbi", self.world_from_sonar[:, :3, :2], table)
        return np.broadcast_to(self.world_from_sonar[:, None, :3, 3], directions.shape), directions

    def first_again(self) -> Heads:
        """Return the same number of poses, all equal to the first, so that the terrain stays in the caches."""
        poses = ("positions_world_m", "orientations_xyzw", "world_from_body", "world_from_sonar")
        return replace(
            self, **{name: np.repeat(getattr(self, name)[:1], len(self.positions_world_m), 0) for name in poses}
        )


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often each case is measured; medians are reported.")] = 15,
    pings: Annotated[int, typer.Option(min=1, help="Number of pings, from different places, in a measurement.")] = 200,
    growth: Annotated[bool, typer.Option(help="Also measure the cost against the number of triangles.")] = True,
    plot: PlotFile = None,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    sim = lake()
    heads, scattered = heads_at(sim, along_lines(pings)), heads_at(sim, scattered_over_area(pings))
    vertices, triangles, _ = sim.world.surface_mesh()
    console.print(f"the lake: {len(triangles):,} triangles; {pings} pings of {len(heads.angles_rad):,} beams a round")
    with tempfile.TemporaryDirectory() as folder:
        cases = our_cases(sim, heads) | {"ping_scattered": Pings(sim, scattered)}
        cases |= peer_cases(heads, vertices, triangles, Path(folder))
        cases |= limit_cases(scattered, vertices, triangles, Path(folder) / "scattered.bin", "_scattered")
        for size in SIZES if growth else ():
            grown = lake(size)
            for suffix, places in {"": heads, "_scattered": scattered, "_again": heads.first_again()}.items():
                cases[f"triangles_{size}{suffix}"] = Pings(grown, places)
        rates = alternated(cases, rounds, warm_up=True)
    results = summarise(rates)
    console.print(_table(results))
    if growth:
        results |= _growth(results, plot)
    return results


def summarise(rates: dict[str, list[float]]) -> dict[str, float]:
    """Return the median pings per second of each case, and the medians of the goals' ratios."""
    results = medians(rates)
    for places in ("", "_scattered"):
        limits = [f"limit_{kind}{places}" for kind in LIMITS]
        if limits[0] in results:
            best = max(limits, key=results.__getitem__)
            rates[f"limit{places}"], results[f"limit{places}"] = rates[best], results[best]
    for name in GOALS:
        one, other = name.split("/")
        if one in rates and other in rates:
            results[name] = ratio(rates[one], rates[other])
    return results


def lake(triangles: int | None = None) -> Simulator:
    """Return the lake, with a terrain of about `triangles` triangles."""
    scenario = load("lake").with_changes(sonar_model=SONAR_MODEL)
    if triangles is not None:
        terrain: Any = scenario.terrain
        spacing_m = terrain.size_m[0] / round(np.sqrt(triangles / 2))
        terrain = terrain.model_copy(update={"spacing_m": spacing_m})
        scenario = scenario.model_copy(update={"terrain": terrain, "obstacles": ()})
    sim = Simulator(scenario)
    sim.rov.release()
    return sim


def along_lines(count: int) -> tuple[NDArray[np.float64], Rotation]:
    """Return positions (count, 2) along parallel lines over the survey's area, with small random rotations."""
    (west, east), (south, north) = AREA_M
    line, along = np.divmod(np.arange(count) * PINGS_APART_M, east - west)
    back = line % 2 == 1
    x = np.where(back, east - along, west + along)
    y = (south + north) / 2 + LINES_APART_M * line
    wobble = np.random.default_rng(1).normal(0, [1, 2, 2], (count, 3))
    return np.column_stack([x, y]), Rotation.from_euler("ZYX", wobble + np.outer(back, [180, 0, 0]), degrees=True)


def scattered_over_area(count: int) -> tuple[NDArray[np.float64], Rotation]:
    """Return random positions (count, 2) in the survey's area, with any heading and some pitch and roll."""
    random = np.random.default_rng(1)
    xy = np.column_stack([random.uniform(low, high, count) for low, high in AREA_M])
    return xy, Rotation.from_euler("ZYX", random.normal(0, [180, 5, 5], (count, 3)), degrees=True)


def heads_at(sim: Simulator, places: tuple[NDArray[np.float64], Rotation]) -> Heads:
    """Return the poses at the survey's altitude above the bed."""
    xy, turns = places
    z = np.minimum(sim.world.height_at(xy) + ALTITUDE_M, -1.0)
    positions = np.column_stack([xy, z])
    world_from_body = np.tile(np.eye(4), (len(xy), 1, 1))
    world_from_body[:, :3, :3] = turns.as_matrix()
    world_from_body[:, :3, 3] = positions
    batch = sim.rov.sonar.ping_batch(world_from_body)
    return Heads(
        positions,
        turns.as_quat(),
        world_from_body,
        batch.world_from_sonar,
        np.linspace(float(batch.angles_rad[0]), float(batch.angles_rad[-1]), len(batch.angles_rad)),
        sim.rov.sonar.model.range_max_m,
    )


class Pings:
    """Single pings from Python, each from a new pose; a call returns the pings per second of one thread.

    share: of the poses, for a kind of ping that is slow.
    """

    def __init__(self, sim: Simulator, heads: Heads, share: float = 1.0) -> None:
        self._rov = sim.rov
        positions = heads.positions_world_m.copy()
        # Coarser terrain may be slightly higher.
        positions[:, 2] = np.maximum(positions[:, 2], sim.world.height_at(positions[:, :2]) + 1.0)
        every = round(1.0 / share)
        self._places = list(zip(positions, heads.orientations_xyzw, strict=True))[::every]

    def __call__(self) -> float:
        """Return pings per second, excluding the time to place the vehicle."""
        elapsed_s, rov, sonar = 0.0, self._rov, self._rov.sonar
        for position, orientation in self._places:
            rov.place(position, orientation)
            elapsed_s += spent_s(sonar.ping, time.thread_time)
        return len(self._places) / elapsed_s


def our_cases(sim: Simulator, heads: Heads) -> dict[str, Callable[[], float]]:
    """Return uwsim's cases: single pings, batches on one and two threads, physics mode with and without its options."""
    poses = heads_at(sim, along_lines(5 * len(heads.world_from_body))).world_from_body

    def batch(threads: int) -> Callable[[], float]:
        pings = partial(sim.rov.sonar.ping_batch, poses, threads=threads)
        return lambda: len(poses) / spent_s(pings, time.perf_counter)

    cases: dict[str, Callable[[], float]] = {"ping": Pings(sim, heads), "batch_1": batch(1), "batch_2": batch(2)}
    first = sim.scenario.vehicles[0]
    modes = {"physics": {}, "physics_bent": {"bending": True}, "physics_multipath": {"multipath": True}}
    for name, more in (modes | {"physics_water_column": {"water_column": True}}).items():
        sonar = first.sonar.model_copy(update={"mode": "physics", **more})
        acoustic = Simulator(sim.scenario.model_copy(update={"vehicles": (first.model_copy(update={"sonar": sonar}),)}))
        acoustic.rov.release()
        cases[name] = Pings(acoustic, heads, 0.1 if "water_column" in more else 1.0)
    return cases


def peer_cases(
    heads: Heads, vertices_m: NDArray[np.float64], triangles: NDArray[np.uint32], folder: Path
) -> dict[str, Callable[[], float]]:
    """Return the cases to compare with: the limit and the installed peers, all with the same surface and rays."""
    case = folder / "case.bin"
    cases = limit_cases(heads, vertices_m, triangles, case)
    add_native(cases, "bullet", heads, "bullet_fan", case)
    for name, make in {"pybullet": pybullet_peer, "trimesh": trimesh_peer}.items():
        try:
            cases[name] = make(heads, vertices_m, triangles, folder)
        except ImportError as error:
            console.print(f"{name} left out: {error} (pip install {error.name})")
    return cases


def limit_cases(
    heads: Heads, vertices_m: NDArray[np.float64], triangles: NDArray[np.uint32], case: Path, suffix: str = ""
) -> dict[str, Callable[[], float]]:
    """Return cases of Embree's bare packets, one for each variant that may be the fastest."""
    write_case(heads, vertices_m, triangles, case)
    cases: dict[str, Callable[[], float]] = {}
    for name, options in LIMITS.items():
        add_native(cases, f"limit_{name}{suffix}", heads, "embree_fan", case, *options)
    return cases


def add_native(cases: dict[str, Callable[[], float]], name: str, heads: Heads, program: str, *options: object) -> None:
    """Add a native peer, measured in pings per second of its processor time."""
    if found := native_program(program):
        peer, pings = NativePeer(found, *options), len(heads.world_from_sonar)
        cases[name] = lambda: pings / peer.times_s()[0]


def write_case(heads: Heads, vertices_m: NDArray[np.float64], triangles: NDArray[np.uint32], path: Path) -> None:
    """Write the input of the native peers; see native/ray_case.h."""
    turns, positions = heads.world_from_sonar[:, :3, :3], heads.world_from_sonar[:, :3, 3]
    counts = len(vertices_m), len(triangles), len(heads.angles_rad), len(positions)
    with path.open("wb") as file:
        file.write(struct.pack("<4Qd", *counts, heads.range_m))
        file.write(vertices_m.astype(np.float32).tobytes())
        file.write(triangles.astype(np.uint32).tobytes())
        file.write(np.column_stack([np.cos(heads.angles_rad), np.sin(heads.angles_rad)]).tobytes())
        file.write(np.hstack([turns.reshape(-1, 9), positions]).tobytes())


def pybullet_peer(heads: Heads, vertices_m: Any, triangles: Any, folder: Path) -> Callable[[], float]:
    """Return a peer that casts the same rays with pybullet's rayTestBatch on one thread, converting arrays as well."""
    import pybullet as p

    mesh = folder / "surface.obj"
    with mesh.open("w", encoding="ascii") as file:
        np.savetxt(file, vertices_m, fmt="v %.7g %.7g %.7g")
        np.savetxt(file, triangles + 1, fmt="f %d %d %d")
    p.connect(p.DIRECT)
    shape = p.createCollisionShape(p.GEOM_MESH, fileName=str(mesh), flags=p.GEOM_FORCE_CONCAVE_TRIMESH)
    p.createMultiBody(0, shape)
    origins, directions = heads.rays
    few = min(10, len(origins))  # it is slow

    def run() -> float:
        begun = time.thread_time()
        for start, direction in zip(origins[:few], directions[:few], strict=True):
            hits = p.rayTestBatch(start.tolist(), (start + heads.range_m * direction).tolist(), numThreads=1)
            np.array([hit[2] for hit in hits]) * heads.range_m
        return few / (time.thread_time() - begun)

    return run


def trimesh_peer(heads: Heads, vertices_m: Any, triangles: Any, folder: Path) -> Callable[[], float]:
    """Return a peer that casts the same rays by trimesh with embreex, from arrays to points of first hits."""
    import embreex  # noqa: F401
    import trimesh
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    mesh = RayMeshIntersector(trimesh.Trimesh(vertices_m, triangles, process=False))
    origins, directions = heads.rays
    few = min(50, len(origins))

    def run() -> float:
        begun = time.thread_time()
        for start, direction in zip(origins[:few], directions[:few], strict=True):
            mesh.intersects_id(start, direction, multiple_hits=False, return_locations=True)
        return few / (time.thread_time() - begun)

    return run


def _table(results: dict[str, float]) -> Table:
    labels = {
        "ping": "a ping from Python, all outputs",
        "batch_1": "ping_batch, one thread",
        "batch_2": "ping_batch, two threads",
        "physics": "a ping in physics mode, 8 rays per beam",
        "physics_bent": "the same with bent rays",
        "physics_multipath": "the same with multipath",
        "physics_water_column": "the same with the water column",
        "limit_quads": "bare Embree packets, quads",
        "limit_triangles": "bare Embree packets, triangles",
        "limit_incoherent": "bare Embree packets, incoherent",
        "bullet": "Bullet's rayTest, C++",
        "pybullet": "pybullet's rayTestBatch",
        "trimesh": "trimesh with embreex",
        "ping_scattered": "a ping from Python, scattered places",
        "limit_scattered": "bare Embree packets, scattered places",
    }
    title = "Pings of 1,025 beams to 95 m over the lake: medians"
    table = new_table(title, "case", "pings/s", "us per ping", "goal", "met")
    for key, label in labels.items():
        if key in results:
            table.add_row(label, f"{results[key]:,.0f}", f"{1e6 / results[key]:,.1f}", "", "")
    table.add_section()
    for name, goal in GOALS.items():
        if name in results:
            at_most = name.startswith(("ping/physics", "physics/"))
            limit, met = goal_cells(results[name], goal, at_most=at_most)
            table.add_row(name, f"{results[name]:,.2f}", "", f"at {'most' if at_most else 'least'} {limit}", met)
    return table


def _growth(results: dict[str, float], path: Path | None) -> dict[str, float]:
    """Print the cost against the number of triangles, with the best straight line in log n; draw it if asked for."""
    sizes, slopes, figure = np.array(SIZES), {}, new_figure(7.0, 4.5)
    panel = figure.subplots()
    for suffix, label in GROWTH.items():
        cost_us = np.array([1e6 / results[f"triangles_{size}{suffix}"] for size in SIZES])
        slope, offset = np.polyfit(np.log10(sizes), cost_us, 1)
        (line,) = panel.semilogx(sizes, cost_us, "o-", label=label)
        fitted = offset + slope * np.log10(sizes)
        panel.semilogx(sizes, fitted, "--", color=line.get_color(), alpha=0.6, label=f"{slope:.1f} us per decade")
        rows = ", ".join(f"{size:,}: {cost:.0f}" for size, cost in zip(SIZES, cost_us, strict=True))
        console.print(f"us per ping {label}, by triangles: {rows}; {slope:.1f} us per decade")
        slopes[f"us_a_decade{suffix}"] = float(slope)
    panel.set(xlabel="triangles", ylabel="us per ping of 1,025 beams", ylim=(0, None), title="Cost by size")
    panel.legend()
    if path is not None:
        save_figure(figure, path)
    return slopes
