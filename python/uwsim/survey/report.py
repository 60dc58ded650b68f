"""Writes the survey's report: one self-contained HTML file."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from uwsim.atomic_file import write_atomically
from uwsim.link.table import HEADINGS
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.score_text import coverage_text, distance_text, order_met, order_rows
from uwsim.survey.record import SurveyRecord
from uwsim.survey.report_figures import ReportFigure
from uwsim.survey.summary import ashore_text, duration_text, key_figures, survey_warnings

TEMPLATE = Path(__file__).with_name("report.html.j2")
STYLE = Path(__file__).with_name("report_style.css")


def write_report(
    path: Path,
    record: SurveyRecord,
    score: MapScore,
    free_voxel_count: int,
    figures: Sequence[ReportFigure],
    ashore: MapScore | None = None,
) -> None:
    """Write the report atomically, with the figures inside it as data URIs. Raises OSError if that fails."""
    page = filled_page(
        TEMPLATE,
        record=record,
        highlights=_highlights(record, score),
        warnings=survey_warnings(record, score),
        key_figures=key_figures(record, score, free_voxel_count),
        orders=order_rows(score),
        order_met=order_met(score),
        judged=_judged_cells(score),
        setup=_setup(record),
        stages=_stages(record),
        link=[row.texts() for row in record.ashore.table()] if record.ashore is not None else [],
        link_headings=HEADINGS,
        ashore=None if ashore is None else ashore_text(record, ashore),
        figures=[(figure, data_uri(figure.path)) for figure in figures],
    )
    write_atomically(path, page.encode("utf-8"))


def filled_page(template: Path, **values: Any) -> str:
    """Return a page from a template, in the common style."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    style = Markup(STYLE.read_text(encoding="utf-8"))
    return environment.from_string(template.read_text(encoding="utf-8")).render(style=style, **values)


def _judged_cells(score: MapScore) -> str:
    """Return a sentence on how many cells of the seabed were judged, and how many were not."""
    if score.seabed is None:
        return "The map is empty."
    judged, obstructed = int(score.seabed.judged.sum()), int(score.seabed.obstructed.sum())
    cell = f"{score.resolution_m:g} x {score.resolution_m:g} m"
    return f"{judged:,} cells of {cell} were judged; {obstructed:,} lie under an obstacle and were not."


def _highlights(record: SurveyRecord, score: MapScore) -> list[tuple[str, str]]:
    share = coverage_text(score).split(" of ")[0] if score.visible_truth_voxels else "-"
    return [
        (share, "of the visible surface mapped"),
        (distance_text(score.distance_mean_m), "mean distance to the truth"),
        (duration_text(record.simulated_s), "simulated"),
        (f"{record.real_time_factor:.1f} x", "real time"),
    ]


def _setup(record: SurveyRecord) -> list[tuple[str, str]]:
    ping = record.sample_ping
    beams = f"{len(ping.ranges_m):,} beams, " if ping is not None else ""
    return [
        ("scenario", record.scenario_name),
        ("seed", str(record.seed)),
        ("sonar model", f"{record.sonar_model} ({beams}range {record.range_max_m:g} m)"),
        ("time step", f"{record.step_s * 1000.0:g} ms"),
        ("voxel", f"{record.voxel_m:g} m"),
        ("outlier filter", "on" if record.outlier_filter else "off"),
        ("threads", str(record.threads)),
        ("ended because", record.stopped_because),
    ]


def _stages(record: SurveyRecord) -> list[tuple[str, str, float]]:
    """Return rows of (stage, wall time, per cent of the survey's wall time)."""
    stages = {**record.stage_wall_s, "the rest": record.rest_wall_s}
    if record.threads > 1 and "map" in stages:
        stages = {("map (in parallel)" if name == "map" else name): wall_s for name, wall_s in stages.items()}
    return [(name, duration_text(wall_s), 100.0 * wall_s / max(record.wall_s, 1e-9)) for name, wall_s in stages.items()]


def data_uri(path: Path) -> str:
    """Return a PNG as a URI that holds it."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
