"""Writes a flight report: a self-contained HTML file, with figures both embedded and saved next to it."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.atomic_file import write_atomically
from uwsim.figures.flight import (
    draw_budget,
    draw_depth,
    draw_depth_profile,
    draw_estimate,
    draw_growth,
    draw_power,
    draw_track,
)
from uwsim.figures.html_page import data_uri, filled_page
from uwsim.figures.map_from_above import draw_map_from_above
from uwsim.figures.map_plans import draw_map_errors
from uwsim.figures.sonar_fan import sonar_fan
from uwsim.figures.truth_and_map import TruthAndMap, draw_truth_and_map, render_truth_and_map
from uwsim.flight.record import FlightRecord
from uwsim.flight.samples import Samples
from uwsim.flight.summary import ashore_text, duration_text, key_figures, vehicle_figures, warnings
from uwsim.missions.own_vehicle import Event
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.score_text import coverage_text, distance_text, order_met, order_rows
from uwsim.simulator.link_traffic import HEADINGS
from uwsim.simulator.simulator import Simulator

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


TEMPLATE = Path(__file__).with_name("report.html.j2")
EVENTS_SHOWN = 300
POSE_BY = {"truth": "the truth", "filter": "the vehicle's own filter", "odometry": "the odometry that it sends"}


def write_report(
    path: Path, flown: FlightRecord, sim: Simulator | None, rendered: Future[TruthAndMap] | None = None
) -> None:
    """Draw the figures next to the report and write it atomically. Raises OSError.

    sim: None if the true world is unknown. rendered: the 3D pictures, if they are already being rendered.
    """
    figures = map_figures(path.parent, flown, sim.world, sim.scene, rendered) if sim is not None else []
    figures += flight_figures(path.parent, flown, None if sim is None else sim.world)
    write_page(path, flown, figures)


def write_page(path: Path, flown: FlightRecord, figures: Sequence[ReportFigure]) -> None:
    """Write the report atomically, with figures embedded as data URIs. Raises OSError."""
    score, ashore = flown.score, flown.ashore_score
    page = filled_page(
        TEMPLATE,
        flown=flown,
        link_headings=HEADINGS,
        link_rows=[row.texts() for row in flown.link],
        pose_by=POSE_BY[flown.estimate],
        title=f"{flown.mission} in {flown.scenario}",
        warnings=warnings(flown),
        tiles=_highlights(flown),
        key_figures=key_figures(flown),
        vehicles={name: vehicle_figures(samples) for name, samples in flown.samples.items()},
        figures=[(figure, data_uri(figure.path)) for figure in figures],
        events=[_event_row(event) for event in flown.events[:EVENTS_SHOWN]],
        events_left=max(0, len(flown.events) - EVENTS_SHOWN),
        lanes=[] if flown.lanes is None else [_lane_row(lane) for lane in flown.lanes.each],
        thrusters={name: _thruster_rows(samples) for name, samples in flown.samples.items()},
        orders=[] if score is None else order_rows(score),
        order_met="-" if score is None else order_met(score),
        judged="" if score is None else _judged_cells(score),
        setup=_setup(flown),
        stages=_stages(flown),
        ashore=None if ashore is None else ashore_text(flown, ashore),
    )
    write_atomically(path, page.encode("utf-8"))


def _judged_cells(score: MapScore) -> str:
    """Return a sentence that states how many seabed cells were evaluated and how many were not."""
    if score.seabed is None:
        return "The map is empty."
    judged, obstructed = int(score.seabed.judged.sum()), int(score.seabed.obstructed.sum())
    cell = f"{score.resolution_m:g} x {score.resolution_m:g} m"
    return f"{judged:,} cells of {cell} were judged; {obstructed:,} lie under an obstacle and were not."


def _highlights(flown: FlightRecord) -> list[tuple[str, str]]:
    tiles = [(duration_text(flown.simulated_s), "simulated"), (f"{flown.real_time_factor:.1f} x", "real time")]
    path_m = sum(float(np.linalg.norm(np.diff(s.path_world_m, axis=0), axis=1).sum()) for s in flown.samples.values())
    if flown.samples:
        tiles += [(f"{path_m:,.0f} m", "flown"), (str(flown.collisions), "collisions")]
    if (score := flown.score) is None:
        return tiles
    share = coverage_text(score).split(" of ")[0] if score.visible_truth_voxels else "-"
    mapped = [
        (share, "of the visible surface mapped"), (distance_text(score.distance_mean_m), "mean distance to the truth"),
    ]  # fmt: skip
    return [*mapped, *tiles]


def _setup(flown: FlightRecord) -> list[tuple[str, str]]:
    rows = [("scenario", flown.scenario), ("mission", flown.mission)]
    if flown.seed is not None:
        rows.append(("seed", str(flown.seed)))
    if flown.sonar_model is not None:
        ping = flown.sample_ping
        beams = f"{len(ping.ranges_m):,} beams, " if ping is not None else ""
        rows.append(("sonar model", f"{flown.sonar_model} ({beams}range {flown.range_max_m:g} m)"))
    if flown.step_s is not None:
        rows.append(("time step", f"{flown.step_s * 1000.0:g} ms"))
    if flown.occupancy is not None:
        rows += [("voxel", f"{flown.voxel_m:g} m"), ("outlier filter", "on" if flown.outlier_filter else "off")]
    return [*rows, ("threads", str(flown.threads)), ("ended because", flown.ended_because)]


def _stages(flown: FlightRecord) -> list[tuple[str, str, float]]:
    """Return rows of (stage, wall time, percentage of the flight's total wall time)."""
    if not flown.stage_wall_s:
        return []
    stages = {**flown.stage_wall_s, "the rest": flown.rest_wall_s}
    if flown.threads > 1 and "map" in stages:
        stages = {("map (in parallel)" if name == "map" else name): wall_s for name, wall_s in stages.items()}
    return [(name, duration_text(wall_s), 100.0 * wall_s / max(flown.wall_s, 1e-9)) for name, wall_s in stages.items()]


def _thruster_rows(samples: Samples) -> list[tuple[str, float]]:
    """Return rows of (name, mean absolute command in per cent)."""
    commands = np.abs(samples.commands)
    return list(zip(samples.command_names, (100.0 * commands.mean(axis=0)).tolist(), strict=True))


def _lane_row(lane: dict[str, Any]) -> tuple[str, str, str]:
    name = f"{lane['vehicle']}, {lane['number'] + 1}"
    return name, f"{lane['flown_m']:,.1f} of {lane['planned_m']:,.1f} m", lane.get("because", "")


def _event_row(event: Event) -> tuple[str, str, str, str]:
    return f"{event.time_s:.1f} s", event.vehicle, event.name.replace("_", " "), _text(event.values)


def _text(values: dict[str, Any]) -> str:
    return ", ".join(f"{key} {_short(value)}" for key, value in values.items())


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list):
        return "(" + ", ".join(map(_short, value)) + ")"
    return str(value)
