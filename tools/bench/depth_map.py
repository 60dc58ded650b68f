"""The depth-map method against one ray a beam: how far its ranges are off, and what it costs, at several resolutions.

All ways take turns within one run, at the same places over the lake, so that what else the machine does falls on each
alike; medians over the rounds. The exact ranges are the multibeam's own, one ray a beam.
"""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation

from uwsim import Simulator, _core
from uwsim.depth_map import DepthMap, Difference, difference, ranges_m

console = Console()

TILT_RAD = np.radians(30.0)  # as the lake's survey flies
ALTITUDE_M = 8.0
AREA_M = ((-100.0, -76.0), (50.0, 20.0))  # of the survey; pipeline and gate are in it
# Pixels across all cameras, rows, cameras, whether interpolated, bits of a stored depth. Of 64 rows none lies in the
# fan's plane, of 65 the middle one does.
WAYS = (
    (256, 1, 1, False, 0), (512, 1, 1, False, 0), (1024, 1, 1, False, 0), (2048, 1, 1, False, 0),
    (8192, 1, 1, False, 0), (1024, 1, 1, True, 0), (1024, 1, 1, False, 16), (1024, 1, 1, False, 8),
    (1024, 64, 1, False, 0), (1024, 65, 1, False, 0), (1024, 1, 4, False, 0),
)  # fmt: skip


@dataclass
class Way:
    """One way to make a ping's ranges, what it costs, and how it differs from the exact ones."""

    name: str
    rays: int
    run: Callable[[int], Any]
    seconds: list[float]
    off: Difference | None = None


def main(
    model: Annotated[int, typer.Option(min=1, max=4, help="EM 2040 variant.")] = 2,
    places: Annotated[int, typer.Option(min=1, help="Pings, spread over the survey's area.")] = 40,
    rounds: Annotated[int, typer.Option(min=1, help="How often each way is measured; medians are reported.")] = 5,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here too.")] = None,
) -> None:
    """Compare ranges and cost."""
    sim = Simulator("lake", sonar_model=model, threads=1)
    poses = _poses(sim, places)
    ways = [_rays(sim, poses), *(_depth_map(sim, poses, way) for way in WAYS)]
    exact = [np.asarray(ways[0].run(k)) for k in range(places)]
    for way in ways[1:]:
        way.off = difference(np.concatenate([way.run(k) for k in range(places)]), np.concatenate(exact))
    for turn in range(rounds):
        with console.status(f"round {turn + 1} of {rounds}"):
            for way in ways:
                begun = time.thread_time()
                for k in range(places):
                    way.run(k)
                way.seconds.append((time.thread_time() - begun) / places)
    console.print(_table(ways, sim.rov.sonar.model, places))
    if json_file is not None:
        json_file.write_text(json.dumps(_figures(ways), indent=2) + "\n", encoding="utf-8")


def _poses(sim: Simulator, count: int) -> list[np.ndarray]:
    """Of the sonar, on a low-discrepancy set (Roberts' R2) over the area, headings all around."""
    (x0, y0), (x1, y1) = AREA_M
    poses = []
    for k in range(count):
        x = x0 + (x1 - x0) * ((0.5 + 0.7548776662466927 * k) % 1.0)
        y = y0 + (y1 - y0) * ((0.5 + 0.5698402909980532 * k) % 1.0)
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_euler("ZY", [2.399963 * k, TILT_RAD]).as_matrix()
        pose[:3, 3] = x, y, float(sim.world.height_at([[x, y]])[0]) + ALTITUDE_M
        poses.append(pose)
    return poses


def _angles_rad(model: _core.MultibeamModel) -> np.ndarray:
    return model.angle_min_rad + model.angle_increment_rad * np.arange(model.beams)


def _rays(sim: Simulator, poses: list[np.ndarray]) -> Way:
    """One ray a beam, from Python as the others are."""
    model = sim.rov.sonar.model
    angles = _angles_rad(model)
    flat = np.stack([np.cos(angles), np.sin(angles), np.zeros(model.beams)], axis=1)

    def run(k: int) -> np.ndarray:
        found = sim.scene.cast(poses[k][None, :3, 3], flat @ poses[k][:3, :3].T, model.range_max_m).ranges_m
        return np.where(found < model.range_max_m, found, np.inf)

    return Way("a ray for each beam", model.beams, run, [])


def _depth_map(sim: Simulator, poses: list[np.ndarray], way: tuple[int, int, int, bool, int]) -> Way:
    width, height, cameras, interpolate, bits = way
    sonar = sim.rov.sonar.model
    model = DepthMap(
        field_of_view_rad=sonar.field_of_view_rad, range_max_m=sonar.range_max_m, width=width // cameras,
        height=height, cameras=cameras, vertical_fov_rad=np.radians(1.0 if height == 1 else 20.0),
        interpolate=interpolate, depth_bits=bits,
    )  # fmt: skip
    angles = _angles_rad(sonar)
    notes = [f"{cameras} cameras"] * (cameras > 1) + ["interpolated"] * interpolate + [f"{bits} bits"] * (bits > 0)
    name = ", ".join([f"{width} x {height}", *notes])
    return Way(name, model.rays, lambda k: ranges_m(sim, poses[k], angles, model), [])


def _figures(ways: list[Way]) -> dict[str, dict[str, float]]:
    """Of each way: seconds a ping, its ratio to rays taken round by round, and how it differs."""
    figures = {}
    for way in ways:
        ratio = statistics.median(mine / rays for mine, rays in zip(way.seconds, ways[0].seconds, strict=True))
        figure: dict[str, float] = {"rays": way.rays, "ping_s": statistics.median(way.seconds), "cost_ratio": ratio}
        figures[way.name] = figure | ({} if way.off is None else vars(way.off))
    return figures


def _table(ways: list[Way], model: _core.MultibeamModel, places: int) -> Table:
    """Cost relative to rays; errors where both echo; beams that lost their echo, and echoes that are not there."""
    table = Table(title=f"{model.name}: {places} pings over the lake", title_justify="left", pad_edge=False, box=None)
    table.add_column("depth image", no_wrap=True)
    for column in ("rays", "us", "cost", "mean mm", "95 % mm", "max m", "lost", "made up"):
        table.add_column(column, justify="right")
    for name, figure in _figures(ways).items():
        row = [f"{figure['rays']:,.0f}", f"{1e6 * figure['ping_s']:.0f}", f"{figure['cost_ratio']:.2f}"]
        if "mean_m" in figure:
            row += [f"{1e3 * figure['mean_m']:.1f}", f"{1e3 * figure['percentile_95_m']:.1f}", f"{figure['max_m']:.2f}"]
            row += [f"{figure['missed']:.0f}", f"{figure['invented']:.0f}"]
        table.add_row(name, *row)
    return table


if __name__ == "__main__":
    typer.run(main)
