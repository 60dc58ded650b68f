"""The packaged forward-looking imaging sonar on the lake, compared with bare Embree casting the same rays.

The cases alternate within one run, so that other load on the machine affects them equally; results are medians over the
rounds, and ratios are computed per round. Each picture is taken from a new position along a line. The native peer casts
the rays of the first picture, in packets of eight columns by two rays, as the sonar does, and alternatively in packets
of four by four rays. It also casts an even grid of two columns of 384 rays per beam, which is less accurate.

A single thread is measured in processor time, and several threads in wall time, which is not meaningful on a busy
machine.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import NativePeer, alternated, console, goal_cells, medians, native_program, new_table, ratio, spent_s
from numpy.typing import NDArray
from rich.table import Table

from uwsim import Simulator

PLACE_M = (-67.0, -52.0, -26.0)  # two metres above the bed, in front of a gate
STEP_M = 0.3
PLACES = 20
SHAPES = {"wide": 8, "square": 4, "grid": 4}  # the columns of rays in a packet
GRID_RAYS = 384  # in each column of the even grid
GOALS = {"picture/wide": 2.0, "picture/grid": 1.5, "picture_ms": 10.0, "wall_ms": 10.0}
PACKET = np.dtype([("kind", "<i4"), ("active", "<i4", 16), ("rows", "<f4", (8, 16))])  # see native/embree_bare_rays.cpp
COHERENT = 2


def main(
    rounds: Annotated[int, typer.Option(min=1, help="How often to measure each case; medians are reported.")] = 15,
    threads: Annotated[int, typer.Option(min=1, help="Threads of the case that is measured in wall time.")] = 2,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    cases: dict[str, Callable[[], float]] = {
        "picture": Pictures(1, time.process_time),
        "wall": Pictures(threads, time.perf_counter),
    }
    peers = []
    with tempfile.TemporaryDirectory() as folder:
        if program := native_program("embree_bare_rays"):
            for shape, columns in SHAPES.items():
                file = Path(folder) / shape
                write_rays(file, columns, GRID_RAYS if shape == "grid" else None)
                peers.append(NativePeer(program, file, 1, "quads"))
                cases[shape] = lambda peer=peers[-1]: peer.times_s()[1]
        seconds = alternated(cases, rounds, warm_up=True)
        for peer in peers:
            peer.close()
    results = {f"{name}_ms": 1e3 * value for name, value in medians(seconds).items()}
    results |= {f"picture/{shape}": ratio(seconds["picture"], seconds[shape]) for shape in SHAPES if shape in seconds}
    console.print(_table(results, threads))
    return results


class Pictures:
    """Pictures from successive positions. A call returns the median time per picture [s]."""

    def __init__(self, threads: int, clock: Callable[[], float]) -> None:
        self._sim, self._clock = lake(threads), clock

    def __call__(self) -> float:
        """Take a picture at each position."""
        rov, elapsed_s = self._sim.rov, []
        for k in range(PLACES):
            rov.place((PLACE_M[0] + STEP_M * k, *PLACE_M[1:]))
            elapsed_s.append(spent_s(rov.imaging_sonars["forward_looking"].look, self._clock))
        return statistics.median(elapsed_s)


def lake(threads: int = 1) -> Simulator:
    """Return the lake, with the vehicle at the first position."""
    sim = Simulator("lake", threads=threads)
    sim.rov.release()
    sim.rov.place(PLACE_M)
    return sim


def directions(sonar: Any, grid_rays: int | None) -> NDArray[np.float64]:
    """Return the directions (columns, rays, 3) of a picture's rays in the world, see forward_looking.cpp.

    grid_rays: the rays in each column of an even grid instead.
    """
    model, world_from_sonar = sonar.model, sonar.world_from_sonar
    spacing = model.field_of_view_rad / (model.beams - 1) / model.columns_per_beam
    reach = int(np.ceil(6 * model.beam_width_rad / spacing))
    columns = (model.beams - 1) * model.columns_per_beam + 1 + 2 * reach
    bearing = (-model.field_of_view_rad / 2 + (np.arange(columns) - reach) * spacing)[:, None]
    span, rays = 1.25 * model.vertical_width_rad, grid_rays or model.rays_per_column
    shift = 0.0 if grid_rays else np.array([-0.375, 0.125, -0.125, 0.375])[np.arange(columns) % 4, None]
    u = -1 + (np.arange(rays) + 0.5 + shift) * 2 / rays
    elevation = span * (u if grid_rays else u * (0.6 + 0.4 * u**2)) + 0 * bearing
    level = np.cos(elevation)
    xyz = np.stack([level * np.cos(bearing), level * np.sin(bearing), np.sin(elevation)], axis=-1)
    return np.asarray(xyz @ world_from_sonar[:3, :3].T)


def write_rays(file: Path, columns: int, grid_rays: int | None) -> None:
    """Write the world's surface and the packets of one picture for the peer.

    columns: columns of rays per packet. grid_rays: see directions.
    """
    sim = lake()
    sonar = sim.rov.imaging_sonars["forward_looking"]
    rays, each = directions(sonar, grid_rays), 16 // columns
    idle = -len(rays) % columns
    active = np.concatenate([np.full(len(rays), -1), np.zeros(idle)]).astype(np.int32)
    rays = np.concatenate([rays, np.repeat(rays[-1:], idle, axis=0)])
    blocks = rays.reshape(-1, columns, rays.shape[1] // each, each, 3).transpose(0, 2, 4, 1, 3)
    packets = np.zeros(blocks.shape[:2], PACKET)
    packets["kind"] = COHERENT
    packets["active"] = np.repeat(active.reshape(-1, columns), each, axis=1)[:, None]
    packets["rows"][..., 3:6, :] = blocks.reshape(*blocks.shape[:3], 16)
    packets["rows"][..., 7, :] = 1.5 * sonar.model.range_max_m
    vertices, triangles, _ = sim.world.surface_mesh()
    with file.open("wb") as out:
        np.array([len(vertices), len(triangles), packets.size], np.uint64).tofile(out)
        (vertices - sonar.world_from_sonar[:3, 3]).astype(np.float32).tofile(out)
        triangles.astype(np.uint32).tofile(out)
        packets.tofile(out)


def _table(results: dict[str, float], threads: int) -> Table:
    labels = {
        "picture_ms": "a picture, processor time of one thread",
        "wall_ms": f"a picture, wall time of {threads} threads",
        "wide_ms": "bare Embree, packets of 8 columns x 2 rays",
        "square_ms": "bare Embree, packets of 4 x 4 rays",
        "grid_ms": "bare Embree, even grid of 429,000 rays, 4 x 4",
        "picture/wide": "a picture against the first, one thread",
        "picture/square": "a picture against the second, one thread",
        "picture/grid": "a picture against the third, one thread",
    }
    title = "forward-looking sonar on the lake, 125,000 rays: medians"
    table = new_table(title, "case", "ms or ratio", "goal, at most", "met")
    for key, label in labels.items():
        if key in results:
            table.add_row(label, f"{results[key]:.2f}", *goal_cells(results[key], GOALS.get(key), at_most=True))
    return table
