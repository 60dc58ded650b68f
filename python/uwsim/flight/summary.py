"""The key values of a flight and its warnings, for the terminal, the report and summary.json."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from uwsim.flight.log import PANEL_WARNINGS
from uwsim.flight.record import FlightRecord
from uwsim.flight.samples import PERIOD_S, Samples
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.score_text import coverage_text, distance_text, score_rows, score_values

WARNING_TEXTS = {"range": "range warning lit", "proximity": "proximity warning lit", "collision": "in contact"}
ENOUGH_PERCENT = 95.0
"""Coverage at which a survey that ended early still counts as complete."""


def key_figures(flown: FlightRecord) -> list[tuple[str, str]]:
    """Return rows of (name, value with unit) about the flight and its map, in display order."""
    rows = [
        ("simulated time", duration_text(flown.simulated_s)),
        ("wall time", duration_text(flown.wall_s)),
        ("real-time factor", f"{flown.real_time_factor:.1f} x"),
        ("collisions", f"{flown.collisions:,}"),
        ("events in the log", f"{len(flown.events):,}"),
        *([] if (lanes := flown.lanes) is None else lanes.rows()),
    ]
    if flown.occupancy is not None:
        rows += [
            ("pings", f"{flown.ping_count:,}"),
            ("echoes", f"{flown.echo_count:,}"),
            ("path flown while pinging", f"{flown.path_length_m:,.0f} m"),
            *_error_rows(flown),
            *warning_rows(flown),
        ]
    if flown.score is not None:
        rows += [
            ("occupied voxels", f"{flown.score.occupied_voxels:,}"),
            ("free voxels", f"{flown.free_voxels:,}"),
            *score_rows(flown.score),
        ]
    rows += [] if flown.soundings is None else flown.soundings.rows()
    return rows


def _error_rows(flown: FlightRecord) -> list[tuple[str, str]]:
    error = flown.position_error_m
    if flown.estimate != "filter" or not len(error):
        return []
    return [("error of the pings' positions", f"mean {error.mean():.2f} m, largest {error.max():.2f} m")]


def warning_rows(flown: FlightRecord) -> list[tuple[str, str]]:
    """Return a row for each panel warning: its condition, and the share of pings during which it was on."""
    limits_m = flown.warning_limits_m
    meanings = {
        "range": f"pings over {limits_m.get('range', 0.0):g} m from the station",
        "proximity": f"pings under {limits_m.get('proximity', 0.0):g} m above the bed",
        "collision": "pings in contact",
    }
    count = max(flown.ping_count, 1)
    return [(meanings[name], _share_text(lit / count)) for name, lit in flown.pings_with_warning.items()]


def _share_text(share: float) -> str:
    """Format a share as `63 %`; a share above 0 is never rounded to 0 %, nor one below 1 to 100 %."""
    percent = f"{100.0 * share:.0f}" if share in (0.0, 1.0) else f"{min(max(100.0 * share, 0.1), 99.9):.3g}"
    return f"{percent} %"


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
    """Return one vehicle's key values by name, in SI units, for JSON."""
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
        "warnings_lit_s": {name: samples.lit_s(name) for name in PANEL_WARNINGS},
        "estimate_rms_m": float(np.sqrt((errors**2).mean())) if len(errors) else 0.0,
        "estimate_max_m": float(errors.max(initial=0.0)),
    }


def flight_values(flown: FlightRecord) -> dict[str, Any]:
    """Return the flight's key values by name, in SI units, for JSON. The map's score is under `map`."""
    errors_m, made = flown.position_error_m, flown.occupancy is not None
    values = {
        "mission": flown.mission,
        "scenario": flown.scenario,
        "seed": flown.seed,
        "estimate": flown.estimate,
        "sonar_model": flown.sonar_model,
        "ended_because": flown.ended_because,
        "ended_early": flown.ended_early,
        "result": flown.result if isinstance(flown.result, bool | int | float | str) else None,
        "simulated_s": flown.simulated_s,
        "wall_s": flown.wall_s,
        "stage_wall_s": {**flown.stage_wall_s, "the rest": flown.rest_wall_s},
        "threads": flown.threads,
        "step_s": flown.step_s,
        "sample_period_s": PERIOD_S,
        "events": len(flown.events),
        "collisions": flown.collisions,
        "pings": flown.ping_count,
        "echoes": flown.echo_count,
        "path_length_m": flown.path_length_m,
        "outlier_filter": flown.outlier_filter if made else None,
        "ping_interval_s": flown.ping_interval_s if made else None,
        "range_max_m": flown.range_max_m if made else None,
        "pings_with_warning": flown.pings_with_warning,
        "position_error_mean_m": float(errors_m.mean()) if len(errors_m) else 0.0,
        "lanes_left_out": flown.lanes_left_out,
        "lanes": None if (lanes := flown.lanes) is None else lanes._asdict(),
        "map_verified": flown.verified,
        "free_voxels": flown.free_voxels if flown.score is not None else None,
        "map_growth": [row._asdict() for row in flown.map_growth],
        "link": [row._asdict() for row in flown.link],
        "vehicles": {name: vehicle_values(samples) for name, samples in flown.samples.items()},
        "warnings": warnings(flown),
    }
    if flown.ashore is not None and flown.ashore_score is not None:
        values["ashore"] = {"pings": flown.ashore.ping_count, **score_values(flown.ashore_score, path_known=True)}
    if flown.soundings is not None:
        values["soundings"] = flown.soundings.values()
    if flown.score is not None:
        values["map"] = score_values(flown.score, path_known=True)
    return values


def warnings(flown: FlightRecord) -> list[str]:
    """Return the warnings that a reader should see before trusting the key values."""
    found = []
    if flown.error is not None:
        found.append(f"The mission failed: {flown.error}")
    elif flown.ended_early:
        found.append(f"The mission ended early: {flown.ended_because}.")
    if flown.occupancy is not None and flown.ping_count == 0:
        found.append("The flight ended before its first ping: there is no path and no echo to show.")
    if flown.lanes_left_out is not None:
        found.append(flown.lanes_left_out)
    if (score := flown.score) is not None:
        if score.occupied_voxels == 0:
            found.append("The map is empty: no voxel is occupied.")
        elif flown.planned and score.visible_truth_voxels and 100.0 * score.coverage < ENOUGH_PERCENT:
            found.append(f"The map is incomplete: coverage is {coverage_text(score)}, less than {ENOUGH_PERCENT:g} %.")
    if flown.ping_interval_s > flown.ping_interval_requested_s + 1e-9:
        requested_hz, actual_hz = 1.0 / flown.ping_interval_requested_s, 1.0 / flown.ping_interval_s
        found.append(
            f"The sonar pinged at {actual_hz:.3g} Hz, not {requested_hz:.3g}: "
            f"sound takes longer to {flown.range_max_m:g} m and back."
        )
    if flown.collisions:
        times = "was a collision" if flown.collisions == 1 else f"were {flown.collisions:,} collisions"
        found.append(f"There {times}.")
    return found


def coverage_shortfall(flown: FlightRecord, min_coverage_percent: float | None = None) -> str | None:
    """Return a sentence about the shortfall if map coverage is below the minimum, else None.

    min_coverage_percent: by default ENOUGH_PERCENT for a flight that ended early, for example because its battery was
    empty, and no minimum for a flight that completed its mission.
    """
    least = min_coverage_percent
    if least is None:
        least = ENOUGH_PERCENT if flown.ended_early else 0.0
    coverage = 100.0 * (flown.coverage or 0.0)
    if coverage >= least:
        return None
    why = f"it ended early: {flown.ended_because}" if flown.ended_early else "its mission is complete"
    if flown.coverage is None:
        return f"the survey is incomplete: its coverage is unknown, since the map was not scored; {why}"
    shown = math.floor(10.0 * coverage) / 10.0  # rounded down, so that it does not seem to reach the minimum
    return f"the survey is incomplete: coverage is {shown:.1f} %, must be at least {least:g} %; {why}"


def ashore_text(flown: FlightRecord, score: MapScore) -> str:
    """Return a summary of the map built by the station."""
    count = 0 if flown.ashore is None else flown.ashore.ping_count
    share = coverage_text(score) if score.visible_truth_voxels else "-"
    distance = f", mean distance to the truth {distance_text(score.distance_mean_m)}" if score.occupied_voxels else ""
    return f"the map ashore: {count:,} of {flown.ping_count:,} pings, {share} covered{distance}"


def summary_table(flown: FlightRecord) -> Table:
    """Return the key values as a table for the terminal, with the warnings below it.

    On a narrow terminal, names wrap and values stay on one line.
    """
    seed = "" if flown.seed is None else f", seed {flown.seed}"
    sonar = "" if flown.sonar_model is None else f", sonar model {flown.sonar_model}"
    title = f"{escape(flown.mission)} in {escape(flown.scenario)}{seed}{sonar}"
    table = Table(title=title, title_justify="left", show_header=False)
    table.add_column("name", style="cyan", overflow="fold")
    table.add_column("value", justify="right", no_wrap=True)
    for name, value in key_figures(flown):
        table.add_row(name, value)
    for vehicle, samples in flown.samples.items():
        table.add_section()
        for name, value in vehicle_figures(samples):
            table.add_row(f"{vehicle}: {name}" if len(flown.samples) > 1 else name, value)
    if found := warnings(flown):
        table.caption = Text("\n".join(f"warning: {warning}" for warning in found), style="bold yellow")
        table.caption_justify = "left"
    return table


def duration_text(seconds: float) -> str:
    """Format a duration as `21 min 52 s`, or as `4.2 s` if it is under a minute."""
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s"


def _metres(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f} m"
