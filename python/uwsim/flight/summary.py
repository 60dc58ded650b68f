"""The key figures of a flight, for the terminal, the report and summary.json."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwsim.flight.record import FlightRecord
from uwsim.flight.samples import PERIOD_S, WARNINGS, Samples
from uwsim.scoring.score_text import score_rows
from uwsim.survey.summary import duration_text

WARNING_TEXTS = {"range": "range warning lit", "proximity": "proximity warning lit", "collision": "in contact"}


def key_figures(flown: FlightRecord) -> list[tuple[str, str]]:
    """Return rows of (name, value with unit) about the flight and its map."""
    rows = [
        ("simulated time", duration_text(flown.simulated_s)),
        ("wall time", duration_text(flown.wall_s)),
        ("real-time factor", f"{flown.real_time_factor:.1f} x"),
        ("collisions", f"{flown.collisions:,}"),
        ("events in the log", f"{len(flown.events):,}"),
    ]
    if flown.occupancy is not None:
        rows += [("pings in the map", f"{len(flown.all_pings_world_m):,}"), ("echoes", f"{flown.echo_count:,}")]
    if flown.score is not None:
        rows += score_rows(flown.score)
    for name, closed in flown.closed.items():
        values, of = _closed_values(flown, name), f" of {name}" if len(flown.closed) > 1 else ""
        rows += [
            (f"loops closed{of}", f"{closed.matched} of {closed.tried} overlaps, {closed.submaps} submaps"),
            (f"closed track{of}, RMS error", f"{values['error_rms_m']:.2f} m"),
            (f"closed track{of}, largest error", f"{values['error_max_m']:.2f} m"),
        ]
    return rows


def vehicle_figures(samples: Samples) -> list[tuple[str, str]]:
    """Return rows of (name, value with unit) about one vehicle."""
    figures = vehicle_values(samples)
    rows = [
        ("path", f"{figures['path_length_m']:,.1f} m"),
        ("deepest", f"{figures['depth_max_m']:.1f} m"),
        ("nearest to the bed", _metres(figures["altitude_min_m"])),
        ("fastest", f"{figures['speed_max_m_s']:.2f} m/s"),
        ("battery left", f"{figures['battery_percent']:.1f} %"),
        ("thrust, mean command", f"{100.0 * figures['command_mean']:.0f} %"),
    ]
    rows += [(WARNING_TEXTS[name], duration_text(lit_s)) for name, lit_s in figures["warnings_lit_s"].items()]
    if figures["estimate_rms_m"] > 0.0:
        rows += [
            ("estimate, RMS error", f"{figures['estimate_rms_m']:.2f} m"),
            ("estimate, largest error", f"{figures['estimate_max_m']:.2f} m"),
        ]
    return rows


def vehicle_values(samples: Samples) -> dict[str, Any]:
    """Return the figures of one vehicle by name, in SI units, for JSON."""
    free = samples["released"] > 0
    altitudes = samples["altitude_m"][free & np.isfinite(samples["altitude_m"])]
    steps = np.linalg.norm(np.diff(samples.path_world_m, axis=0), axis=1)
    errors = np.linalg.norm(samples.estimated_path_world_m - samples.path_world_m, axis=1)
    commands = np.abs(samples.commands)
    return {
        "path_length_m": float(steps.sum()),
        "depth_max_m": float(samples["depth_m"].max(initial=0.0)),
        "altitude_min_m": float(altitudes.min()) if len(altitudes) else None,
        "speed_max_m_s": float(samples["speed_m_s"].max(initial=0.0)),
        "battery_percent": float(samples["battery_percent"][-1]) if len(samples) else None,
        "collisions": int(samples["collisions"][-1]) if len(samples) else 0,
        "command_mean": float(commands.mean()) if commands.size else 0.0,
        "command_mean_by_name": dict(zip(samples.command_names, commands.mean(axis=0).tolist(), strict=True)),
        "warnings_lit_s": {name: samples.lit_s(name) for name in WARNINGS},
        "estimate_rms_m": float(np.sqrt((errors**2).mean())) if len(errors) else 0.0,
        "estimate_max_m": float(errors.max(initial=0.0)),
    }


def flight_values(flown: FlightRecord) -> dict[str, Any]:
    """Return the figures of the flight by name, in SI units, for JSON."""
    return {
        "mission": flown.mission,
        "scenario": flown.scenario,
        "seed": flown.seed,
        "estimate": flown.estimate,
        "ended_because": flown.ended_because,
        "ended_early": flown.ended_early,
        "simulated_s": flown.simulated_s,
        "wall_s": flown.wall_s,
        "step_s": flown.step_s,
        "sample_period_s": PERIOD_S,
        "events": len(flown.events),
        "pings": len(flown.all_pings_world_m),
        "echoes": flown.echo_count,
        "map_growth": [row._asdict() for row in flown.map_growth],
        "link": [row._asdict() for row in flown.link],
        "closed": {name: _closed_values(flown, name) for name in flown.closed},
        "vehicles": {name: vehicle_values(samples) for name, samples in flown.samples.items()},
    }


def _closed_values(flown: FlightRecord, name: str) -> dict[str, Any]:
    closed = flown.closed[name]
    errors = closed.errors_m
    return {
        "submaps": closed.submaps,
        "overlaps": closed.tried,
        "matched": closed.matched,
        "error_rms_m": float(np.sqrt(np.mean(errors**2))) if len(errors) else 0.0,
        "error_max_m": float(errors.max(initial=0.0)),
    }


def warnings(flown: FlightRecord) -> list[str]:
    """Return the sentences that a reader must know first."""
    told = []
    if flown.error is not None:
        told.append(f"The mission failed: {flown.error}")
    elif flown.ended_early:
        told.append(f"The mission ended early: {flown.ended_because}.")
    if flown.collisions:
        told.append(
            "There was a collision." if flown.collisions == 1 else f"There were {flown.collisions:,} collisions."
        )
    if flown.score is not None and flown.score.occupied_voxels == 0:
        told.append("The map is empty: no voxel is occupied.")
    return told


def _metres(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f} m"
