"""Writes the report of a flight: one self-contained HTML file, with its figures inside and beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.atomic_file import write_atomically
from uwsim.figures.flight import draw_depth, draw_estimate, draw_power, draw_track
from uwsim.figures.growth import draw_growth
from uwsim.figures.map_errors import draw_map_errors
from uwsim.figures.map_from_above import draw_map_from_above
from uwsim.figures.truth_and_map import draw_truth_and_map, render_truth_and_map
from uwsim.flight.record import FlightRecord
from uwsim.flight.samples import Samples
from uwsim.flight.summary import key_figures, vehicle_figures, warnings
from uwsim.link.table import HEADINGS
from uwsim.missions.own_vehicle import Event
from uwsim.simulator import Simulator
from uwsim.survey.report import data_uri, filled_page
from uwsim.survey.summary import duration_text

TEMPLATE = Path(__file__).with_name("report.html.j2")
REPORT = "report.html"
EVENTS_SHOWN = 300
POSE_BY = {"truth": "the truth", "filter": "the vehicle's own filter", "odometry": "the odometry that it tells"}
MOVED_M = 1e-6  # an estimate that differs less is the truth


class Figure(NamedTuple):
    """A picture of the report. wide: too wide for a phone, to be pushed aside with a finger."""

    path: Path
    title: str
    caption: str
    wide: bool = False


def write_report(
    out: Path,
    flown: FlightRecord,
    sim: Simulator | None,
    area_m: NDArray[np.float64] | None,
    occupied_m: NDArray[np.floating] | None,
) -> None:
    """Draw the figures and write the report. Raises OSError."""
    figures = _flight_figures(out, flown, sim)
    if sim is not None and flown.score is not None and area_m is not None and occupied_m is not None:
        figures += _map_figures(out, flown, sim, area_m, occupied_m)
    page = filled_page(
        TEMPLATE,
        flown=flown,
        link_headings=HEADINGS,
        pose_by=POSE_BY[flown.estimate],
        title=f"{flown.mission} in {flown.scenario}",
        warnings=warnings(flown),
        highlights=_highlights(flown),
        key_figures=key_figures(flown),
        vehicles={name: vehicle_figures(samples) for name, samples in flown.samples.items()},
        figures=[(figure, data_uri(figure.path)) for figure in figures],
        events=[_event_row(event) for event in flown.events[:EVENTS_SHOWN]],
        events_left=max(0, len(flown.events) - EVENTS_SHOWN),
        thrusters={name: _thruster_rows(samples) for name, samples in flown.samples.items()},
    )
    write_atomically(out / REPORT, page.encode())


def _highlights(flown: FlightRecord) -> list[tuple[str, str]]:
    tiles = [(duration_text(flown.simulated_s), "simulated"), (f"{flown.real_time_factor:.1f} x", "real time")]
    path_m = sum(float(np.linalg.norm(np.diff(s.path_world_m, axis=0), axis=1).sum()) for s in flown.samples.values())
    tiles.append((f"{path_m:,.0f} m", "flown"))
    tiles.append((str(flown.collisions), "collisions"))
    if flown.score is not None:
        tiles.append((f"{100.0 * flown.score.coverage:.1f} %", "of the visible surface mapped"))
        tiles.append((f"{flown.score.distance_mean_m:.2f} m", "mean distance of the map to the truth"))
    return tiles


def _flight_figures(out: Path, flown: FlightRecord, sim: Simulator | None) -> list[Figure]:
    tracks = {name: samples.path_world_m for name, samples in flown.samples.items()}
    errors = {
        name: np.linalg.norm(samples.estimated_path_world_m - samples.path_world_m, axis=1)
        for name, samples in flown.samples.items()
    }
    errors = {name: error for name, error in errors.items() if error.max(initial=0.0) > MOVED_M}
    estimates = {name: flown.samples[name].estimated_path_world_m for name in errors}
    figures = [Figure(out / "track.png", "Where it went", "From the circle to the square.")]
    closed = {name: path.path_world_m for name, path in flown.closed.items()}
    draw_track(figures[0].path, None if sim is None else sim.world, tracks, estimates, closed)
    for name, samples in flown.samples.items():
        of = f" of {name}" if len(flown.samples) > 1 else ""
        tag = f"_{name}" if len(flown.samples) > 1 else ""
        z_m = samples["z_m"]
        depth = Figure(
            out / f"depth{tag}.png", f"Depth and altitude{of}", "Its height, and that of what lies below it."
        )
        draw_depth(depth.path, samples["time_s"], z_m, z_m - samples["altitude_m"], samples["collision_warning"] > 0)
        power = Figure(
            out / f"power{tag}.png",
            f"Commands and battery{of}",
            "Each command, from -1 to 1, and what is left of the battery.",
        )
        draw_power(power.path, samples["time_s"], samples.commands, samples.command_names, samples["battery_percent"])
        figures += [depth, power]
    if errors:
        text = "How far the vehicle was from where it thought it was"
        text += ", and from where it is taken to have been once loops were closed." if flown.closed else "."
        figures.append(Figure(out / "estimate.png", "Estimate against truth", text))
        curves = {name: (flown.samples[name]["time_s"], error) for name, error in errors.items()}
        for name, path in flown.closed.items():
            curves[f"{name}, loops closed"] = (path.times_s, path.errors_m)
        draw_estimate(figures[-1].path, curves)
    return figures


def _map_figures(
    out: Path, flown: FlightRecord, sim: Simulator, area_m: NDArray[np.float64], occupied_m: NDArray[np.floating]
) -> list[Figure]:
    score = flown.score
    assert score is not None
    first, path_m = next(iter(flown.pings_world_m.items()))
    whose = f" The line is the way of {first}." if len(flown.pings_world_m) > 1 else ""
    figures = [
        Figure(
            out / "truth_and_map.png", "Truth and map",
            f"The area flown over, cut out of the true world, and the occupied voxels of the map.{whose}", wide=True,
        ),
        Figure(
            out / "map_from_above.png", "The map from above",
            f"The highest occupied voxel of each column. What was in sight but is missing is pink.{whose}", wide=True,
        ),
        Figure(
            out / "where_it_is_wrong.png", "Where the map is wrong",
            "The depth of each cell's voxels compared with the true terrain.", wide=True,
        ),
    ]  # fmt: skip
    if flown.map_growth:
        figures.append(
            Figure(
                out / "map_growth.png", "The map as it grew",
                "The area in which it holds something, and how far its voxels are from the true surface.",
            )
        )  # fmt: skip
        draw_growth(figures[-1].path, [row._asdict() for row in flown.map_growth])
    rendered = render_truth_and_map(sim.world, sim.scene, area_m, occupied_m, score.resolution_m)
    draw_truth_and_map(figures[0].path, rendered, path_m)
    draw_map_from_above(figures[1].path, area_m, path_m, score, occupied_m, "area flown over")
    draw_map_errors(figures[2].path, score, area_m)
    return figures


def _thruster_rows(samples: Samples) -> list[tuple[str, float]]:
    """Return (name, mean command in per cent)."""
    commands = np.abs(samples.commands)
    return list(zip(samples.command_names, (100.0 * commands.mean(axis=0)).tolist(), strict=True))


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
