"""The depth-map method compared with one ray per beam: range errors and cost at several resolutions.

All methods alternate within one run, at the same poses over the lake, so that other load on the machine affects all of
them equally; results are medians over the rounds. The exact ranges are the multibeam's own, one ray per beam.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer
from _harness import alternated, console, ratio, spent_s
from rich.table import Table
from scipy.spatial.transform import Rotation

from uwsim import Simulator, _core
from uwsim.instruments.sonars.depth_map import DepthMap, Difference, difference, ranges_m

TILT_RAD = np.radians(30.0)  # as in the lake's survey
ALTITUDE_M = 8.0
AREA_M = ((-100.0, -76.0), (50.0, 20.0))  # the survey area, with pipeline and gate
# Total columns of all cameras, rows, number of cameras, whether interpolated, bits of a quantised depth. With 64 rows,
# no row lies in the fan's plane; with 65, the middle row does.
METHODS = (
    (256, 1, 1, False, 0), (512, 1, 1, False, 0), (1024, 1, 1, False, 0), (2048, 1, 1, False, 0),
    (8192, 1, 1, False, 0), (1024, 1, 1, True, 0), (1024, 1, 1, False, 16), (1024, 1, 1, False, 8),
    (1024, 64, 1, False, 0), (1024, 65, 1, False, 0), (1024, 1, 4, False, 0),
)  # fmt: skip


@dataclass
class Method:
    """A method of computing the ranges of a ping, its cost, and its differences from the exact ranges."""

    name: str
    rays: int
    run: Callable[[int], Any]
    seconds: list[float] = field(default_factory=list)
    off: Difference | None = None

    def ping_s(self, places: int) -> float:
        """Return the processor time of a ping."""
        return spent_s(lambda: [self.run(k) for k in range(places)], time.thread_time) / places


def main(
    model: Annotated[int, typer.Option(min=1, max=4, help="EM 2040 variant.")] = 2,
    places: Annotated[int, typer.Option(min=1, help="Pings, spread over the survey's area.")] = 40,
    rounds: Annotated[int, typer.Option(min=1, help="How often each method is measured; medians are reported.")] = 5,
) -> dict[str, Any]:
    """Compare ranges and cost."""
    sim = Simulator("lake", sonar_model=model, threads=1)
    poses = _poses(sim, places)
    methods = [_rays(sim, poses), *(_depth_map(sim, poses, setting) for setting in METHODS)]
    exact = [np.asarray(methods[0].run(k)) for k in range(places)]
    for method in methods[1:]:
        method.off = difference(np.concatenate([method.run(k) for k in range(places)]), np.concatenate(exact))
    found = alternated({k: partial(method.ping_s, places) for k, method in enumerate(methods)}, rounds)
    for k, method in enumerate(methods):
        method.seconds = found[k]
    console.print(_table(methods, sim.rov.sonar.model, places))
    return _results(methods)


def _poses(sim: Simulator, count: int) -> list[np.ndarray]:
    """Return poses of the sonar spread over the area by a low-discrepancy sequence (Roberts' R2), with all headings."""
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


def _rays(sim: Simulator, poses: list[np.ndarray]) -> Method:
    """Return the method that casts one ray per beam; like the others, it is called from Python."""
    model = sim.rov.sonar.model
    angles = _angles_rad(model)
    flat = np.stack([np.cos(angles), np.sin(angles), np.zeros(model.beams)], axis=1)

    def run(k: int) -> np.ndarray:
        found = sim.scene.cast(poses[k][None, :3, 3], flat @ poses[k][:3, :3].T, model.range_max_m).ranges_m
        return np.where(found < model.range_max_m, found, np.inf)

    return Method("a ray for each beam", model.beams, run)


def _depth_map(sim: Simulator, poses: list[np.ndarray], setting: tuple[int, int, int, bool, int]) -> Method:
    width, height, cameras, interpolate, bits = setting
    sonar = sim.rov.sonar.model
    model = DepthMap(
        field_of_view_rad=sonar.field_of_view_rad, range_max_m=sonar.range_max_m, width=width // cameras,
        height=height, cameras=cameras, vertical_fov_rad=np.radians(1.0 if height == 1 else 20.0),
        interpolate=interpolate, depth_bits=bits,
    )  # fmt: skip
    angles = _angles_rad(sonar)
    notes = [f"{cameras} cameras"] * (cameras > 1) + ["interpolated"] * interpolate + [f"{bits} bits"] * (bits > 0)
    name = ", ".join([f"{width} x {height}", *notes])
    return Method(name, model.rays, lambda k: ranges_m(sim, poses[k], angles, model))


def _results(methods: list[Method]) -> dict[str, dict[str, float]]:
    """Return for each method the seconds per ping, the cost relative to rays in each round, and the range errors."""
    results = {}
    for method in methods:
        result: dict[str, float] = {
            "rays": method.rays,
            "ping_s": statistics.median(method.seconds),
            "cost_ratio": ratio(method.seconds, methods[0].seconds),
        }
        results[method.name] = result | ({} if method.off is None else vars(method.off))
    return results


def _table(methods: list[Method], model: _core.MultibeamModel, places: int) -> Table:
    """Return a table of costs relative to rays, errors of beams with both echoes, lost echoes and false echoes."""
    table = Table(title=f"{model.name}: {places} pings over the lake", title_justify="left", pad_edge=False, box=None)
    table.add_column("depth image", no_wrap=True)
    for column in ("rays", "us", "cost", "mean mm", "95 % mm", "max m", "lost", "false"):
        table.add_column(column, justify="right")
    for name, result in _results(methods).items():
        row = [
            f"{result['rays']:,.0f}",
            f"{1e6 * result['ping_s']:.0f}",
            f"{result['cost_ratio']:.2f}",
        ]
        if "mean_m" in result:
            row += [
                f"{1e3 * result['mean_m']:.1f}",
                f"{1e3 * result['percentile_95_m']:.1f}",
                f"{result['max_m']:.2f}",
            ]
            row += [f"{result['missed']:.0f}", f"{result['invented']:.0f}"]
        table.add_row(name, *row)
    return table
