"""Draws the figures of a flight report, with titles and captions."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.figures.depth_profile import draw_depth_profile
from uwsim.figures.flight import draw_budget, draw_depth, draw_estimate, draw_power, draw_track
from uwsim.figures.growth import draw_growth
from uwsim.figures.map_errors import draw_map_errors
from uwsim.figures.map_from_above import draw_map_from_above
from uwsim.figures.sonar_fan import sonar_fan
from uwsim.figures.truth_and_map import TruthAndMap, draw_truth_and_map, render_truth_and_map
from uwsim.flight.record import FlightRecord
from uwsim.flight.samples import Samples

MOVED_M = 1e-6  # an estimate with a smaller error counts as the truth


class ReportFigure(NamedTuple):
    """A PNG on disk, with the title and caption used in the report.

    wide: whether it is too wide for a phone screen and must scroll.
    """

    path: Path
    title: str
    caption: str
    wide: bool = False


def map_figures(
    folder: Path,
    flown: FlightRecord,
    world: _core.World,
    rays: _core.RayScene,
    rendered: Future[TruthAndMap] | None = None,
) -> list[ReportFigure]:
    """Draw the map figures into an existing folder; none if the map was not scored. Raises OSError.

    rays: the ray scene of the same world. rendered: the 3D pictures, if they are already being rendered; otherwise they
    are rendered while the other figures are drawn.
    """
    score, area_m = flown.score, flown.area_world_m
    if flown.occupancy is None or score is None or area_m is None:
        return []
    occupied_m, path_m = flown.occupancy.occupied_voxels(), flown.path_world_m
    if flown.true_pings_world_m or flown.pings_world_m:
        path_m = next(iter((flown.true_pings_world_m or flown.pings_world_m).values()))
    whose = f" The line is the path of {next(iter(flown.pings_world_m))}." if len(flown.pings_world_m) > 1 else ""
    figures = [
        ReportFigure(
            folder / "truth_and_map.png", "Truth and map",
            "The scored area cut out of the true world (left) and the occupied voxels of the map (right), in the "
            f"same view and coloured by height. The orange line is the sonar's path; nothing hides it.{whose}", True,
        ),
        ReportFigure(
            folder / "map_from_above.png", "The map from above",
            "The highest occupied voxel of each column, with the sonar's path. Voxels of the true surface that were in "
            f"line of sight and within range of the path, but are missing in the map, are marked in pink.{whose}", True,
        ),
        ReportFigure(
            folder / "where_it_is_wrong.png", "Where the map is wrong",
            "The depth of each cell's occupied voxels compared with the true terrain: too deep or too shallow; and "
            "voxels that are missing or hold no true surface. Below, the share of cells within each error, and the "
            "errors that IHO S-44 allows.", True,
        ),
    ]  # fmt: skip
    with ThreadPoolExecutor(1, "render") as pool:
        rendered = rendered or pool.submit(render_truth_and_map, world, rays, area_m, occupied_m, score.resolution_m)
        name = "area to survey" if flown.planned else "scored area"
        draw_map_from_above(figures[1].path, area_m, path_m, score, occupied_m, name)
        draw_map_errors(figures[2].path, score, area_m)
        figures += _ping_figures(folder, flown, world, path_m)
        draw_truth_and_map(figures[0].path, rendered.result(), path_m)
    return figures


def _ping_figures(
    folder: Path, flown: FlightRecord, world: _core.World, path_m: NDArray[np.float64]
) -> list[ReportFigure]:
    """Draw the figures that are based on pings."""
    figures = []
    if flown.sample_ping is not None:
        caption = "One ping of the flight as the sonar sent it: from above over the true seabed, and from the side."
        figures.append(ReportFigure(folder / "sonar_fan.png", "The sonar's fan", caption))
        sonar_fan(figures[-1].path, world, flown.sample_ping, flown.range_max_m)
    if len(path_m) > 1:
        caption = "The sonar's depth along its path, and the true seabed straight below it."
        figures.append(ReportFigure(folder / "depth_profile.png", "Depth along the path", caption))
        draw_depth_profile(figures[-1].path, world, path_m)
    if flown.map_growth:
        caption = "The area in which it holds something, and how far its voxels are from the true surface."
        figures.append(ReportFigure(folder / "map_growth.png", "The map as it grew", caption))
        draw_growth(figures[-1].path, [row._asdict() for row in flown.map_growth])
    return figures


def flight_figures(folder: Path, flown: FlightRecord, world: _core.World | None) -> list[ReportFigure]:
    """Draw the figures based on samples into an existing folder. Raises OSError."""
    if not flown.samples:
        return []
    errors = {name: _errors_m(samples) for name, samples in flown.samples.items()}
    errors = {name: error for name, error in errors.items() if error.max(initial=0.0) > MOVED_M}
    figures = [ReportFigure(folder / "track.png", "Track", "The start is a circle, the end a square.")]
    tracks = {name: samples.path_world_m for name, samples in flown.samples.items()}
    estimates = {name: flown.samples[name].estimated_path_world_m for name in errors}
    draw_track(figures[0].path, world, tracks, estimates)
    several = len(flown.samples) > 1
    for name, samples in flown.samples.items():
        figures += _vehicle_figures(folder, samples, f" of {name}" if several else "", f"_{name}" if several else "")
    if errors:
        text = "Distance of the estimated position from the true one."
        figures.append(ReportFigure(folder / "estimate.png", "Estimate against truth", text))
        curves = {name: (flown.samples[name]["time_s"], error) for name, error in errors.items()}
        draw_estimate(figures[-1].path, curves)
    for name, budget_m in flown.budgets_m.items():
        text = "Standard deviations of the estimated position at the end by their source; their squares add up."
        png = folder / f"estimate_budget{f'_{name}' if several else ''}.png"
        figures.append(ReportFigure(png, "Which metre comes from what", text))
        draw_budget(png, budget_m)
    return figures


def _errors_m(samples: Samples) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(samples.estimated_path_world_m - samples.path_world_m, axis=1), np.float64)


def _vehicle_figures(folder: Path, samples: Samples, of: str, tag: str) -> list[ReportFigure]:
    z_m = samples["z_m"]
    depth = ReportFigure(
        folder / f"depth{tag}.png", f"Depth and altitude{of}", "Heights of the vehicle and of the bed below it."
    )
    draw_depth(depth.path, samples["time_s"], z_m, z_m - samples["altitude_m"], samples["collision_warning"] > 0)
    power = ReportFigure(
        folder / f"power{tag}.png", f"Commands and battery{of}",
        "Commands, from -1 to 1, and the remaining battery charge.",
    )  # fmt: skip
    draw_power(power.path, samples["time_s"], samples.commands, samples.command_names, samples["battery_percent"])
    return [depth, power]
