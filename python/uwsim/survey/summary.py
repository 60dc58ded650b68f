"""The summary of a survey: key figures and warnings, as the terminal's table and the report show them."""

from __future__ import annotations

from typing import Any

from rich.markup import escape
from rich.table import Table
from rich.text import Text

from uwsim.scoring.map_score import MapScore
from uwsim.scoring.score_text import coverage_text, distance_text, score_rows
from uwsim.survey.completeness import ENOUGH_PERCENT
from uwsim.survey.record import SurveyRecord

GOOD_COVERAGE = ENOUGH_PERCENT / 100.0


def key_figures(record: SurveyRecord, score: MapScore, free_voxel_count: int) -> list[tuple[str, str]]:
    """Return rows of (name, value with unit) about the survey and its map, in the order in which they are shown."""
    return [
        ("simulated time", duration_text(record.simulated_s)),
        ("wall time", duration_text(record.wall_s)),
        ("real-time factor", f"{record.real_time_factor:.1f} x"),
        ("pings", f"{record.ping_count:,}"),
        ("echoes", f"{record.echo_count:,}"),
        ("path flown while pinging", f"{record.path_length_m:,.0f} m"),
        ("collisions", f"{record.collision_count:,}"),
        *_error_rows(record),
        *warning_rows(record),
        ("occupied voxels", f"{score.occupied_voxels:,}"),
        ("free voxels", f"{free_voxel_count:,}"),
        *score_rows(score),
    ]


def ashore_text(record: SurveyRecord, score: MapScore) -> str:
    """Return a sentence on the map that the station has made."""
    count = 0 if record.ashore is None else record.ashore.ping_count
    share = coverage_text(score) if score.visible_truth_voxels else "-"
    distance = f", mean distance to the truth {distance_text(score.distance_mean_m)}" if score.occupied_voxels else ""
    return f"the map ashore: {count:,} of {record.ping_count:,} pings, {share} covered{distance}"


def _error_rows(record: SurveyRecord) -> list[tuple[str, str]]:
    error = record.position_error_m
    if record.estimate == "truth" or not len(error):
        return []
    return [("error of the estimated position", f"mean {error.mean():.2f} m, largest {error.max():.2f} m")]


def flight_values(record: SurveyRecord) -> dict[str, Any]:
    """Return the figures of the flight by name, SI units, for JSON."""
    return {
        "scenario": record.scenario_name,
        "seed": record.seed,
        "sonar_model": record.sonar_model,
        "ended_because": record.stopped_because,
        "ended_early": record.ended_early,
        "map_verified": record.verified,
        "simulated_s": record.simulated_s,
        "wall_s": record.wall_s,
        "stage_wall_s": {**record.stage_wall_s, "the rest": record.rest_wall_s},
        "threads": record.threads,
        "step_s": record.step_s,
        "outlier_filter": record.outlier_filter,
        "ping_interval_s": record.ping_interval_s,
        "range_max_m": record.range_max_m,
        "pings": record.ping_count,
        "echoes": record.echo_count,
        "path_length_m": record.path_length_m,
        "collisions": record.collision_count,
        "pings_with_warning": record.pings_with_warning,
        "lanes_left_out": record.lanes_left_out,
        "estimate": record.estimate,
        "position_error_mean_m": float(record.position_error_m.mean()) if len(record.position_error_m) else 0.0,
    }


def warning_rows(record: SurveyRecord) -> list[tuple[str, str]]:
    """Return a row for each warning of the vehicle's panel: when it is lit, and for what share of the pings it was."""
    limits_m = record.warning_limits_m
    meanings = {
        "range": f"pings over {limits_m.get('range', 0.0):g} m from the station",
        "proximity": f"pings under {limits_m.get('proximity', 0.0):g} m above the bed",
        "collision": "pings in contact",
    }
    count = max(record.ping_count, 1)
    return [(meanings[name], _share_text(lit / count)) for name, lit in record.pings_with_warning.items()]


def _share_text(share: float) -> str:
    """Return a share as `63 %`; one above 0 is not rounded down to 0, nor one below 1 up to 100 %."""
    percent = f"{100.0 * share:.0f}" if share in (0.0, 1.0) else f"{min(max(100.0 * share, 0.1), 99.9):.3g}"
    return f"{percent} %"


def summary_table(record: SurveyRecord, score: MapScore, free_voxel_count: int) -> Table:
    """Return the key figures as a table for the terminal, with the warnings below it.

    On a narrow terminal the names are folded and the values stay whole.
    """
    title = f"Survey of {escape(record.scenario_name)}, seed {record.seed}, sonar model {record.sonar_model}"
    table = Table(title=title, title_justify="left", show_header=False)
    table.add_column("figure", style="cyan", overflow="fold")
    table.add_column("value", justify="right", no_wrap=True)
    for name, value in key_figures(record, score, free_voxel_count):
        table.add_row(name, value)
    if warnings := survey_warnings(record, score):
        table.caption = Text("\n".join(f"warning: {warning}" for warning in warnings), style="bold yellow")
        table.caption_justify = "left"
    return table


def survey_warnings(record: SurveyRecord, score: MapScore) -> list[str]:
    """Return the sentences that a reader must know before trusting the key figures."""
    warnings = []
    if record.ping_count == 0:
        warnings.append("The survey ended before its first ping: there is no path and no echo to show.")
    elif record.ended_early:
        warnings.append(f"The mission ended early ({record.stopped_because}): part of the area was not surveyed.")
    if record.lanes_left_out is not None:
        warnings.append(record.lanes_left_out)
    if score.occupied_voxels == 0:
        warnings.append("The map is empty: no voxel is occupied.")
    elif score.visible_truth_voxels and score.coverage < GOOD_COVERAGE:
        limit = f"{100.0 * GOOD_COVERAGE:g} %"
        warnings.append(f"The map is incomplete: coverage is {coverage_text(score)}, less than {limit}.")
    if record.ping_interval_s > record.ping_interval_requested_s + 1e-9:
        requested_hz, actual_hz = 1.0 / record.ping_interval_requested_s, 1.0 / record.ping_interval_s
        range_max = f"{record.range_max_m:g} m"
        warnings.append(
            f"The sonar pinged at {actual_hz:.3g} Hz, not {requested_hz:.3g}: "
            f"sound takes longer to {range_max} and back."
        )
    if record.collision_count:
        times = "once" if record.collision_count == 1 else f"{record.collision_count:,} times"
        warnings.append(f"The vehicle collided {times}.")
    return warnings


def duration_text(seconds: float) -> str:
    """Return seconds as `21 min 52 s`, or `4.2 s` under a minute."""
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s"
