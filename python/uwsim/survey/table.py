"""The survey in figures: one list that the terminal's table and the report both show."""

from __future__ import annotations

import math

import numpy as np
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from uwsim.survey.record import SurveyRecord
from uwsim.survey.s44 import ORDERS, share_within
from uwsim.survey.score import MapScore

GOOD_COVERAGE = 0.95


def key_figures(record: SurveyRecord, score: MapScore, free_voxel_count: int) -> list[tuple[str, str]]:
    """Return (what, value with unit) of the survey and its map, in the order in which they are shown."""
    return [
        ("simulated time", minutes(record.simulated_s)),
        ("wall time", minutes(record.wall_s)),
        ("real-time factor", f"{record.real_time_factor:.1f} x"),
        ("pings", f"{record.ping_count:,}"),
        ("echoes", f"{record.echo_count:,}"),
        ("path flown while pinging", f"{record.path_length_m:,.0f} m"),
        ("collisions", f"{record.collision_count:,}"),
        ("occupied voxels", f"{score.occupied_voxels:,}"),
        ("free voxels", f"{free_voxel_count:,}"),
        *score_figures(score),
    ]


def score_figures(score: MapScore) -> list[tuple[str, str]]:
    """Return (what, value with unit) of a map against the truth."""
    seabed = score.seabed
    return [
        ("coverage", coverage(score)),
        ("recall of visible voxels", share(score.recall if score.visible_truth_voxels else math.nan)),
        ("precision of occupied voxels", share(score.precision)),
        ("map to true surface, mean", distance(score.distance_mean_m)),
        ("map to true surface, 95th percentile", distance(score.distance_p95_m)),
        ("map to true surface, max", distance(score.distance_max_m)),
        ("seabed depth error, mean (+: too deep)", distance(seabed.mean_m if seabed else math.nan)),
        ("seabed depth error, 95th percentile", distance(seabed.p95_m if seabed else math.nan)),
        ("vertical order of IHO S-44", order_met(score)),
    ]


def order_rows(score: MapScore) -> list[tuple[str, str, str]]:
    """Return (order, vertical uncertainty that it allows at the median depth, share of cells that keep to theirs)."""
    seabed = score.seabed
    if seabed is None or not seabed.judged.any():
        return []
    median_m = np.array([np.median(seabed.depths_m)])
    return [
        (order.name, distance(order.tvu_m(median_m)[0]), share(share_within(order, seabed.errors_m, seabed.depths_m)))
        for order in ORDERS
    ]


def order_met(score: MapScore) -> str:
    """Write the strictest order whose vertical uncertainty holds for 95 % of the seabed's cells."""
    if score.seabed is None or not score.seabed.judged.any():
        return "-"
    order = score.seabed.best_order
    return "none" if order is None else order.name


def summary_table(record: SurveyRecord, score: MapScore, free_voxel_count: int) -> Table:
    """Return the key figures as a table for the terminal, with the warnings under it.

    Where it is too narrow, names fold and values stay whole.
    """
    title = f"Survey of {escape(record.scenario_name)}, seed {record.seed}, sonar model {record.sonar_model}"
    table = Table(title=title, title_justify="left", show_header=False)
    table.add_column("figure", style="cyan", overflow="fold")
    table.add_column("value", justify="right", no_wrap=True)
    for name, value in key_figures(record, score, free_voxel_count):
        table.add_row(name, value)
    if cautions := survey_warnings(record, score):
        table.caption = Text("\n".join(f"warning: {caution}" for caution in cautions), style="bold yellow")
        table.caption_justify = "left"
    return table


def survey_warnings(record: SurveyRecord, score: MapScore) -> list[str]:
    """Return what a reader must know before believing the figures, a sentence each."""
    warnings = []
    if record.ping_count == 0:
        warnings.append("The survey ended before its first ping: there is no path and no echo to show.")
    elif record.ended_early:
        warnings.append(f"The mission ended early ({record.stopped_because}): part of the area was not surveyed.")
    if score.occupied_voxels == 0:
        warnings.append("The map is empty: no voxel is occupied.")
    elif score.visible_truth_voxels and score.coverage < GOOD_COVERAGE:
        least = f"{100.0 * GOOD_COVERAGE:g} %"
        warnings.append(f"The map is incomplete: coverage is {coverage(score)}, less than {least}.")
    if record.ping_interval_s > record.ping_interval_asked_s + 1e-9:
        asked, got = 1.0 / record.ping_interval_asked_s, 1.0 / record.ping_interval_s
        reach = f"{record.range_max_m:g} m"
        warnings.append(f"The sonar pinged at {got:.3g} Hz, not {asked:.3g}: sound takes longer to {reach} and back.")
    if record.collision_count:
        times = "once" if record.collision_count == 1 else f"{record.collision_count:,} times"
        warnings.append(f"The vehicle collided {times}.")
    return warnings


def minutes(seconds: float) -> str:
    """Write seconds as `21 min 52 s`, or `4.2 s` under a minute."""
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s"


def distance(metres: float) -> str:
    """Write metres to the millimetre; a dash where nothing was measured."""
    return "-" if math.isnan(metres) else f"{metres:.3f} m"


def share(value: float) -> str:
    """Write a share in per cent, rounded down, so that 100 % is all; a dash where there was nothing to share."""
    return "-" if math.isnan(value) else f"{math.floor(value * 1000.0 + 1e-9) / 10.0:.1f} %"


def coverage(score: MapScore) -> str:
    """Write coverage in per cent of how many voxels; rounded down, so that 100 % is all of them."""
    if score.visible_truth_voxels == 0:
        return "- (no true surface was in sight)"
    return f"{math.floor(score.coverage * 1000.0) / 10.0:.1f} % of {score.visible_truth_voxels:,} voxels"
