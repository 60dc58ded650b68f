"""The growth of cost with size, such as of triangles, beams, vehicles, voxels, pieces of cover or elements of a tether.

The sizes of a panel alternate within each round; processor time. The slope is that of a straight line through the
larger half of the sizes, in logarithms of cost and size: 1 is proportional, 0 does not depend on the size.
"""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from _harness import (
    PlotFile,
    Rounds,
    alternated,
    console,
    flat_water,
    lake_fleet,
    new_table,
    readable,
    spent_s,
)

from uwsim import Batch, Simulator, _core, recording
from uwsim.figures.style import ACCENT, FAINT_INK, INK, MISSED, label_axes, new_figure, save_figure
from uwsim.mapping import OccupancyMap
from uwsim.recording import Recorder

SIDE_M, DEPTH_M = 200.0, 30.0  # of the bed below the pings
FAN_RAD = np.radians(60.0)  # to each side
START_M = (-60.0, -28.0, -10.0)  # in open water of the lake
STEPS = 200
TILE_CELLS, VOXEL_M = 100, 0.2

Costs = dict[str, float]  # the processor time of each operation [s]


class Growth(NamedTuple):
    """A kind of size, and what returns the measurement at a size, which is called once per round."""

    name: str
    of: str
    sizes: Sequence[int]
    prepare: Callable[[int], Callable[[], Costs]]


def main(
    rounds: Rounds = 5,
    only: Annotated[list[str] | None, typer.Option(help="Measure only this panel; may be repeated.")] = None,
    plot: PlotFile = None,
) -> dict[str, Any]:
    """Measure all sizes alternately, print the slopes; the figure has one panel for each kind of size."""
    known = {growth.name: growth for growth in GROWTHS}
    if unknown := set(only or ()) - known.keys():
        raise typer.BadParameter(f"{min(unknown)!r}: must be one of {', '.join(known)}", param_hint="--only")
    found = {name: measured(growth, rounds) for name, growth in known.items() if not only or name in only}
    columns = "size", "operation", "cost at the smallest", "at the largest", "slope"
    table = new_table("processor time; slope: over the larger half of the sizes", *columns, texts=2)
    for panel in found.values():
        for name, costs in panel["cost_s"].items():
            ends = [f"{panel['sizes'][k]:,}: {readable(costs[k])}" for k in (0, -1)]
            table.add_row(panel["of"], name, *ends, f"{panel['slope'][name]:.2f}")
    console.print(table)
    if plot is not None:
        draw(found, plot)
    return found


def measured(growth: Growth, rounds: int) -> dict[str, Any]:
    """Return the sizes, and the median cost at each size and the slope of each operation."""
    cases = [growth.prepare(size) for size in growth.sizes]
    turns = alternated(dict(enumerate(cases)), rounds, what=f"{growth.name}: ")
    costs = {
        name: [statistics.median(turn[name] for turn in turns[k]) for k in range(len(cases))] for name in turns[0][0]
    }
    slopes = {name: slope(growth.sizes, values) for name, values in costs.items()}
    return {"of": growth.of, "sizes": list(growth.sizes), "cost_s": costs, "slope": slopes}


def slope(sizes: Sequence[float], costs: Sequence[float]) -> float:
    """Return the exponent with which the cost grows over the larger half of the sizes."""
    half = len(sizes) // 2
    return float(np.polyfit(np.log(sizes[half:]), np.log(costs[half:]), 1)[0])


def mean_s(call: Callable[[], object], repeats: int = 20) -> float:
    """Return the mean processor time of a call."""
    return spent_s(lambda: [call() for _ in range(repeats)]) / repeats


def bed(cells: int, lowered_m: float = 0.0) -> _core.World:
    """Return a bed of `cells` x `cells` squares over the same area."""
    along = np.linspace(0.0, 12.0 * np.pi, cells + 1)
    heights = -DEPTH_M - lowered_m + np.sin(along)[:, None] * np.cos(along)[None, :]
    world = _core.World()
    world.set_terrain(heights.astype(np.float32), SIDE_M / cells, (-SIDE_M / 2.0, -SIDE_M / 2.0))
    return world


def ping_s(scene: _core.RayScene, beams: int, rng: np.random.Generator) -> float:
    """Return the time of a ping, a fan across x, at random places."""
    angles = np.linspace(-FAN_RAD, FAN_RAD, beams)
    directions = np.column_stack([np.full(beams, 0.1), np.sin(angles), -np.cos(angles)])
    return mean_s(lambda: scene.cast(np.append(rng.uniform(-50.0, 50.0, 2), -10.0)[None, :], directions, 100.0))


def triangles(count: int) -> Callable[[], Costs]:
    """Measure a ping of 512 beams over a bed of `count` triangles, and the preparation of the bed for rays."""
    cells = round(np.sqrt(count / 2.0))
    scene, rng = _core.RayScene(bed(cells)), np.random.default_rng(count)

    def prepare() -> float:
        fresh = bed(cells, rng.uniform())  # a bed that is known already would be shared
        return spent_s(lambda: _core.RayScene(fresh).prepare())

    return lambda: {"a ping of 512 beams": ping_s(scene, 512, rng), "preparing the bed": prepare()}


def beams(count: int) -> Callable[[], Costs]:
    """Measure a ping of `count` beams over a bed of half a million triangles."""
    scene, rng = _core.RayScene(bed(500)), np.random.default_rng(0)
    return lambda: {"a ping": ping_s(scene, count, rng)}


def vehicles(count: int) -> Callable[[], Costs]:
    """Measure a step of `count` vehicles, 5 m apart."""
    starts = [(START_M[0] + 5.0 * (k % 8), START_M[1] + 5.0 * (k // 8), START_M[2]) for k in range(count)]
    sim = Simulator(lake_fleet(starts), threads=1)

    def advance() -> float:
        for rov, start in zip(sim.vehicles.values(), starts, strict=True):
            rov.place(start)
            rov.set_effort(surge=0.2, yaw=0.1)
        return spent_s(lambda: sim.step(STEPS)) / STEPS

    return lambda: {"a step": advance()}


def voxels(count: int) -> Callable[[], Costs]:
    """Measure a ping that adds 10,000 voxels to a map of `count` occupied voxels, and writing that map."""
    cells = np.arange(TILE_CELLS) * VOXEL_M
    x, y = np.meshgrid(cells, cells)
    tile = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]) + 0.5 * VOXEL_M
    side_m, pings = TILE_CELLS * VOXEL_M, max(1, count // TILE_CELLS**2)
    across = int(np.ceil(np.sqrt(pings)))

    def insert(into: OccupancyMap, k: int) -> None:
        east_m, north_m = side_m * (k % across), side_m * (k // across)
        above = (east_m + side_m / 2.0, north_m + side_m / 2.0, 10.0)
        into.insert_scan((tile + np.array([east_m, north_m, 0.0])).astype(np.float32), above)

    filled = OccupancyMap(VOXEL_M)
    for k in range(pings):
        insert(filled, k)
    following = iter(range(pings, 2**30))

    def write() -> None:
        with tempfile.TemporaryDirectory() as folder:
            filled.write(Path(folder) / "map.bt")

    return lambda: {"writing the map": spent_s(write), "a ping": spent_s(lambda: insert(filled, next(following)))}


def members(count: int) -> Callable[[], Costs]:
    """Measure a step of a batch of `count` members, on one thread."""
    batch = Batch("lake", n=count, threads=1)
    efforts = np.random.default_rng(0).uniform(-0.3, 0.3, (count, 6))

    def advance() -> float:
        batch.place(START_M)
        return spent_s(lambda: batch.step(STEPS, efforts)) / STEPS

    return lambda: {"a step of all members": advance()}


def seconds(count: int) -> Callable[[], Costs]:
    """Measure recording `count` simulated seconds without pictures and maps, and reading the recording."""

    def record() -> Costs:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "run.mcap"
            sim = Simulator("pool", threads=1)
            sim.rov.undock()

            def run() -> None:
                with Recorder(sim, path, is_light=True):
                    sim.advance(float(count))

            def read() -> int:
                return sum(1 for _ in recording.open(path).messages())

            return {"recording": spent_s(run), "reading it": spent_s(read)}

    return record


def water(vehicle: dict[str, Any], **others: Any) -> Simulator:
    """Return calm water, 20 m deep over a flat bed, with one vehicle."""
    return flat_water([{"start": {"position_m": [15, 0, -8]}, **vehicle}], **others)


def moved_step_s(sim: Simulator) -> float:
    """Return the time of a step under way."""
    sim.rov.set_effort(surge=0.2, yaw=0.1)
    return spent_s(lambda: sim.step(STEPS)) / STEPS


def pieces(count: int) -> Callable[[], Costs]:
    """Measure a ping and a picture over `count` rocks on the bed, and the start of that world."""
    layer = {"kind": "rock", "name": "rock", "density_per_m2": count / 120.0**2, "size_m": [0.1, 0.5], "seed": 1}

    def start() -> Simulator:
        sim = water({"model": "bluerov2_heavy", "sonar": {"model": 2, "tilt_deg": 60}}, cover=[layer])
        sim.rov.release()
        sim.rov.sonar.ping()
        return sim

    sim, looking, rng = start(), water({"model": "rov"}, cover=[layer]), np.random.default_rng(count)
    camera = looking.rov.cameras["front"].resized(256, 256)

    def ping() -> None:
        sim.rov.place((*rng.uniform(-40.0, 40.0, 2), -17.0))
        sim.rov.sonar.ping()

    def picture() -> None:
        looking.rov.place((*rng.uniform(-40.0, 40.0, 2), -18.0), (0.0, 0.383, 0.0, 0.924))  # 45 degrees down
        camera.capture()

    return lambda: {"a ping": mean_s(ping), "a start": spent_s(start), "a picture": mean_s(picture, 3)}


def elements(count: int) -> Callable[[], Costs]:
    """Measure a step of a vehicle on a tether of `count` elements."""
    sim = water({"model": "bluerov2_heavy", "tether": {"anchor": [-15, 0, -2], "length_m": 50.0, "elements": count}})
    return lambda: {"a step": moved_step_s(sim)}


def joints(count: int) -> Callable[[], Costs]:
    """Measure a step of a vehicle with a chain of `count` hinged links that swing freely."""
    link: dict[str, Any] = {"mass_kg": 0.2, "inertia_kg_m2": [1e-4] * 3, "volume_m3": 1.5e-4}
    link["quadratic_drag"] = [0.1, 1, 1, 0, 0, 0]
    arm = {
        f"link{k}": {
            **link,
            "on": f"link{k - 1}" if k else None,
            "position_m": [0.1 if k else 0.3, 0, 0],
            "hinge": {"axis": [0, k % 2, 1 - k % 2], "viscous_nm_s_rad": 0.01},
        }
        for k in range(count)
    }
    sim = water({"model": {"builds_on": "bluerov2_heavy", "arm": arm}})
    return lambda: {"a step": moved_step_s(sim)}


GROWTHS = (
    Growth("triangles", "triangles of the bed", (8_000, 32_000, 128_000, 512_000, 2_000_000), triangles),
    Growth("beams", "beams of a ping", (64, 128, 256, 512, 1024, 2048, 4096, 8192), beams),
    Growth("vehicles", "vehicles", (1, 2, 4, 8, 16, 32, 64), vehicles),
    Growth("voxels", "occupied voxels of the map", (10_000, 40_000, 160_000, 640_000, 2_560_000), voxels),
    Growth("members", "members of a batch", (1, 4, 16, 64, 256), members),
    Growth("seconds", "recorded seconds", (1, 2, 4, 8, 16), seconds),
    Growth("pieces", "pieces of cover", (1_000, 4_000, 16_000, 64_000, 256_000, 1_024_000), pieces),
    Growth("elements", "elements of a tether", (10, 20, 40, 80, 160, 320), elements),
    Growth("joints", "joints of an arm", (1, 2, 4, 8, 16), joints),
)


def draw(found: dict[str, dict[str, Any]], path: Path) -> None:
    """Draw one panel for each kind of size, with logarithmic axes and a dashed line of slope 1 for comparison."""
    columns = min(4, len(found))
    rows = -(-len(found) // columns)
    figure = new_figure(3.4 * columns, 3.1 * rows)
    figure.set_layout_engine("constrained")
    for k, (name, panel) in enumerate(found.items()):
        axes = figure.add_subplot(rows, columns, k + 1)
        sizes = np.array(panel["sizes"], float)
        for colour, (operation, costs) in zip((ACCENT, INK, MISSED), panel["cost_s"].items(), strict=False):
            label = f"{operation}: slope {panel['slope'][operation]:.2f}"
            axes.loglog(sizes, costs, "o-", color=colour, markersize=4, linewidth=1.4, label=label)
        low, high = axes.get_ylim()
        for costs in panel["cost_s"].values():
            axes.loglog(sizes, costs[-1] * sizes / sizes[-1], "--", color=FAINT_INK, linewidth=0.8)
        axes.set_ylim(low, high * (high / low) ** 0.4)
        label_axes(axes, name, panel["of"], "processor time [s]")
        axes.grid(alpha=0.25)
        axes.legend(fontsize=7.5, frameon=False, loc="upper left")
    save_figure(figure, path)
