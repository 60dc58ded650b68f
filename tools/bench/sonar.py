"""Pings per second on the lake, compared with the rays alone (the limit) and Bullet's ray test.

Single-thread CPU time, except multithreaded ping_batch, which is measured in wall time. All cases ping from the same
poses along the survey's lines. From scattered poses, each ping waits until another part of the ray tree has been
loaded; this is reported separately. The limit is the best rate of Embree's ray packets.
"""

from __future__ import annotations

import struct
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from _harness import NativePeer, Rounds, alternated, console, medians, native_program, ratio, show, spent_s
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.scenario import load

SONAR_MODEL = 3  # 1,025 beams to 95 m
ALTITUDE_M = 8.0
AREA_M = ((-104.0, 56.0), (-80.0, 24.0))  # the lake's survey
LINES_APART_M = 13.0
PINGS_APART_M = 0.3
LIMITS = {"quads": ("coherent", "quads"), "triangles": ("coherent",), "incoherent": ("quads",)}
GOALS = {
    "ping/limit": ">= 0.8",
    "ping_scattered/limit_scattered": ">= 0.8",
    "batch_2/batch_1": ">= 1.7",
    "ping/bullet": ">= 10",
    "ping/physics": "<= 12",
    "physics/physics_bent": "<= 2.5",
    "physics/physics_multipath": "<= 2",
}
Places = tuple[NDArray[np.float64], Rotation]
Cases = dict[str, Callable[[], float]]


class Heads(NamedTuple):
    """The vehicle's positions and orientations and the sonar heads (n, 4, 4) at each ping; the fan's angles."""

    places: list[tuple[NDArray[np.float64], NDArray[np.float64]]]
    world_from_body: NDArray[np.float64]
    world_from_sonar: NDArray[np.float64]
    angles_rad: NDArray[np.float64]


def main(
    rounds: Rounds = 15,
    pings: Annotated[int, typer.Option(min=1, help="Number of pings, from different places, in a measurement.")] = 200,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians: pings per second, and ratios of rates."""
    sim = Simulator(load("lake").with_changes(sonar_model=SONAR_MODEL))
    sim.rov.release()
    heads, scattered = heads_at(sim, along_lines(pings)), heads_at(sim, scattered_over_area(pings))
    surface = sim.world.surface_mesh()[:2]
    console.print(f"the lake: {len(surface[1]):,} triangles; {pings} pings of {len(heads.angles_rad):,} beams a round")
    with tempfile.TemporaryDirectory() as name:
        cases = our_cases(sim, heads) | {"ping_scattered": partial(pings_per_s, sim, scattered)}
        for suffix, places in {"": heads, "_scattered": scattered}.items():
            case = Path(name) / f"case{suffix}"
            write_case(places, sim.rov.sonar.model.range_max_m, *surface, case)
            for kind, options in LIMITS.items():
                cases |= native(f"limit_{kind}{suffix}", pings, "embree_fan", case, *options)
        cases |= native("bullet", pings, "bullet_fan", Path(name) / "case")
        rates = alternated(cases, rounds, warm_up=True)
    results = medians(rates)
    for suffix in ("", "_scattered"):
        limits = [f"limit_{kind}{suffix}" for kind in LIMITS]
        if limits[0] in results:
            best = max(limits, key=results.__getitem__)
            rates[f"limit{suffix}"], results[f"limit{suffix}"] = rates[best], results[best]
    for name in GOALS:
        one, other = name.split("/")
        if one in rates and other in rates:
            results[name] = ratio(rates[one], rates[other])
    show("pings of 1,025 beams to 95 m over the lake, per second, and ratios", results, GOALS)
    return results


def along_lines(count: int) -> Places:
    """Return positions (count, 2) along parallel lines over the survey's area, with small random rotations."""
    (west, east), (south, north) = AREA_M
    line, along = np.divmod(np.arange(count) * PINGS_APART_M, east - west)
    back = line % 2 == 1
    x = np.where(back, east - along, west + along)
    y = (south + north) / 2 + LINES_APART_M * line
    wobble = np.random.default_rng(1).normal(0, [1, 2, 2], (count, 3))
    return np.column_stack([x, y]), Rotation.from_euler("ZYX", wobble + np.outer(back, [180, 0, 0]), degrees=True)


def scattered_over_area(count: int) -> Places:
    """Return random positions (count, 2) in the survey's area, with any heading and some pitch and roll."""
    random = np.random.default_rng(1)
    xy = np.column_stack([random.uniform(low, high, count) for low, high in AREA_M])
    return xy, Rotation.from_euler("ZYX", random.normal(0, [180, 5, 5], (count, 3)), degrees=True)


def heads_at(sim: Simulator, places: Places) -> Heads:
    """Return the poses at the survey's altitude above the bed."""
    xy, turns = places
    positions = np.column_stack([xy, np.minimum(sim.world.height_at(xy) + ALTITUDE_M, -1.0)])
    world_from_body = np.tile(np.eye(4), (len(xy), 1, 1))
    world_from_body[:, :3, :3] = turns.as_matrix()
    world_from_body[:, :3, 3] = positions
    batch = sim.rov.sonar.ping_batch(world_from_body)
    angles_rad = np.linspace(float(batch.angles_rad[0]), float(batch.angles_rad[-1]), len(batch.angles_rad))
    at = list(zip(positions, turns.as_quat(), strict=True))
    return Heads(at, world_from_body, batch.world_from_sonar, angles_rad)


def pings_per_s(sim: Simulator, heads: Heads) -> float:
    """Return single pings from Python a second, by one thread, each from a new pose."""
    elapsed_s = 0.0
    for position, orientation in heads.places:
        sim.rov.place(position, orientation)
        elapsed_s += spent_s(sim.rov.sonar.ping, time.thread_time)
    return len(heads.places) / elapsed_s


def our_cases(sim: Simulator, heads: Heads) -> Cases:
    """Return uwsim's cases: single pings, batches on one and two threads, physics mode with and without its options."""
    poses = heads_at(sim, along_lines(5 * len(heads.world_from_body))).world_from_body

    def batch(threads: int) -> Callable[[], float]:
        pings = partial(sim.rov.sonar.ping_batch, poses, threads=threads)
        return lambda: len(poses) / spent_s(pings, time.perf_counter)

    cases: Cases = {"ping": partial(pings_per_s, sim, heads), "batch_1": batch(1), "batch_2": batch(2)}
    first = sim.scenario.vehicles[0]
    modes = {"physics": {}, "physics_bent": {"bending": True}, "physics_multipath": {"multipath": True}}
    for name, more in modes.items():
        sonar = first.sonar.model_copy(update={"mode": "physics", **more})
        acoustic = Simulator(sim.scenario.model_copy(update={"vehicles": (first.model_copy(update={"sonar": sonar}),)}))
        acoustic.rov.release()
        cases[name] = partial(pings_per_s, acoustic, heads)
    return cases


def native(name: str, pings: int, program: str, *options: object) -> Cases:
    """Return the case of a native peer, if it is there, in pings per second of its processor time."""
    if (found := native_program(program)) is None:
        return {}
    peer = NativePeer(found, *options)
    return {name: lambda: pings / peer.times_s()[0]}


def write_case(
    heads: Heads, range_m: float, vertices_m: NDArray[np.float64], triangles: NDArray[np.uint32], path: Path
) -> None:
    """Write the input of the native peers; see native/ray_case.h."""
    turns, positions = heads.world_from_sonar[:, :3, :3], heads.world_from_sonar[:, :3, 3]
    counts = len(vertices_m), len(triangles), len(heads.angles_rad), len(positions)
    with path.open("wb") as file:
        file.write(struct.pack("<4Qd", *counts, range_m))
        file.write(vertices_m.astype(np.float32).tobytes())
        file.write(triangles.astype(np.uint32).tobytes())
        file.write(np.column_stack([np.cos(heads.angles_rad), np.sin(heads.angles_rad)]).tobytes())
        file.write(np.hstack([turns.reshape(-1, 9), positions]).tobytes())
