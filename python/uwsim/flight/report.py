"""Writes a flight report: a self-contained HTML file, with figures both embedded and saved next to it."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.figures.html_page import data_uri, filled_page
from uwsim.figures.truth_and_map import TruthAndMap
from uwsim.flight.record import FlightRecord
from uwsim.flight.report_figures import ReportFigure, flight_figures, map_figures
from uwsim.flight.samples import Samples
from uwsim.flight.summary import ashore_text, duration_text, key_figures, vehicle_figures, warnings
from uwsim.missions.own_vehicle import Event
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.score_text import coverage_text, distance_text, order_met, order_rows
from uwsim.simulator.link_traffic import HEADINGS
from uwsim.simulator.simulator import Simulator

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
