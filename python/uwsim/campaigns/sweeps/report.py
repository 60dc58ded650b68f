"""The report on a sweep: one HTML file with embedded pictures and links to the worst runs."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.campaigns.sweeps.figures import draw_distributions, draw_effects, draw_sensitivity
from uwsim.campaigns.sweeps.rows import Rows
from uwsim.campaigns.sweeps.sensitivity import sensitivity, sobol_indices_of
from uwsim.campaigns.sweeps.spec import SweepSpec
from uwsim.figures.html_page import data_uri, filled_page
from uwsim.flight.summary import duration_text

TEMPLATE = Path(__file__).with_name("report.html.j2")
LIKELY = ("coverage", "distance_mean_m", "result", "simulated_s", "path_length_m", "collisions", "precision")
"""Metrics that are shown first if the sweep does not select any itself."""
SHOWN, ERRORS_SHOWN, EFFECTS = 6, 20, 12


class Figure(NamedTuple):
    """A picture in the report."""

    path: Path
    title: str
    caption: str


def write_report(path: Path, name: str, spec: SweepSpec, rows: Rows, count: int, again: Mapping[int, Path]) -> None:
    """Draw the pictures and write the page. again: folders of the repeated worst runs. Raises ValueError or OSError."""
    shown = _shown(spec, rows)
    of = spec.objective.metric if spec.objective is not None else (shown[0] if shown else None)
    missed = rows.missed(spec.require)
    page = filled_page(
        TEMPLATE,
        title=name,
        spec=spec,
        count=count,
        rows=rows,
        warnings=_warnings(rows, count, missed, spec),
        tiles=_highlights(rows, count),
        figures=[(figure, data_uri(figure.path)) for figure in _figures(path.parent, spec, rows, shown, of)],
        indices=sobol_indices_of(spec, rows, shown),
        require=[(metric, limits, missed[metric]) for metric, limits in spec.require.items()],
        worst=_worst(path.parent, spec, rows, again),
        failures=_reasons(rows.failed, "error"),
        early_ends=_reasons(rows.ended_early, "ended_because"),
        setup=_setup(spec, rows, count),
    )
    write_atomically(path, page.encode())


def _reasons(rows: Sequence[Mapping[str, Any]], column: str) -> list[tuple[str, int, int]]:
    """Return the commonest reasons in a column, each with the number of its runs and the first of them."""
    first = {str(row[column]): int(row["run"]) for row in reversed(rows)}
    return [
        (why, count, first[why]) for why, count in Counter(str(row[column]) for row in rows).most_common(ERRORS_SHOWN)
    ]


def _shown(spec: SweepSpec, rows: Rows) -> list[str]:
    """Return the metrics to draw: requested numeric ones, or else the most relevant ones that differ between runs."""
    for metric in spec.show:
        rows.require_metric(metric, "show")
    if spec.show:
        return [metric for metric in spec.show if rows.is_numeric(metric)]
    differing = rows.differing()
    first = [spec.objective.metric] if spec.objective is not None else []
    order = [*first, *LIKELY, *differing]
    return [metric for metric in dict.fromkeys(order) if metric in differing][:SHOWN]


def _figures(folder: Path, spec: SweepSpec, rows: Rows, shown: list[str], of: str | None) -> list[Figure]:
    figures = []
    if shown:
        caption = "Histograms of the results; the line is the median."
        figures.append(Figure(folder / "distributions.png", "Distributions", caption))
        draw_distributions(figures[-1].path, rows, shown)
    varied = [name for name in rows.varied if len({str(row.get(name)) for row in rows.rows}) > 1]
    if of is not None and rows.is_numeric(of) and varied:
        caption = "Points are runs; the line connects means of neighbouring runs. Boxes: quartiles, median, extremes."
        figures.append(Figure(folder / "effects.png", f"What {of} depends on", caption))
        draw_effects(figures[-1].path, spec, rows, of, varied[:EFFECTS])
    if shown and varied:
        found = sensitivity(rows, shown)
        if np.isfinite(found.values).any():
            caption = (
                "Spearman's rank correlation: 1 or -1 if the metric always rises or falls with the value, 0 if there "
                "is no monotonic trend. Share: the share of the variance explained by the per-choice means."
            )
            figures.append(Figure(folder / "sensitivity.png", "Sensitivity", caption))
            draw_sensitivity(figures[-1].path, found)
    return figures


def _warnings(rows: Rows, count: int, missed: Mapping[str, int], spec: SweepSpec) -> list[str]:
    notes = []
    if len(rows) < count:
        notes.append(f"{count - len(rows):,} of {count:,} runs are missing: uwsim sweep --resume flies them.")
    if rows.failed:
        notes.append(f"{len(rows.failed):,} runs failed; see below.")
    if rows.ended_early:
        notes.append(f"{len(rows.ended_early):,} runs ended early; see below.")
    if spec.objective is not None and (without := rows.without(spec.objective.metric)):
        notes.append(f"{without:,} runs have no {spec.objective.metric}: figures and ranking are of the others.")
    notes += [f"{n:,} runs violate the limits on {metric}." for metric, n in missed.items() if n]
    if spec.objective is None and spec.worst:
        notes.append("The sweep has no objective, so the worst runs cannot be determined.")
    return notes


def _highlights(rows: Rows, count: int) -> list[tuple[str, str]]:
    walls, flights = rows.numbers("run_wall_s"), rows.numbers("flight_wall_s")
    tiles = [
        (f"{len(rows):,} of {count:,}", "runs"),
        (f"{len(rows.failed):,}", "failed"),
        (f"{len(rows.ended_early):,}", "ended early"),
    ]
    if np.isfinite(walls).any():
        tiles.append((duration_text(float(np.nansum(walls))), "total wall time of the workers"))
    if np.isfinite(walls - flights).any():
        tiles.append((f"{1000.0 * float(np.nanmedian(walls - flights)):.1f} ms", "median overhead of a run"))
    return tiles


def _worst(folder: Path, spec: SweepSpec, rows: Rows, again: Mapping[int, Path]) -> list[dict[str, Any]]:
    by_number = {row["run"]: row for row in rows.rows}
    found = []
    for number in rows.worst(spec.objective, max(spec.worst, len(again))):
        row, run_folder = by_number[number], again.get(number)
        links = []
        if run_folder is not None:
            links = [
                (each, f"{run_folder.relative_to(folder)}/{each}")
                for each in ("report.html", "run.mcap", "map.bt", "scenario.yaml")
                if (run_folder / each).exists()
            ]
        metric = spec.objective.metric if spec.objective else ""
        values = [(name, _short(row.get(name))) for name in rows.varied]
        about = {"run": number, "seed": row["seed"], "value": _short(row[metric])}
        found.append({**about, "values": values, "links": links})
    return found


def _setup(spec: SweepSpec, rows: Rows, count: int) -> list[tuple[str, str]]:
    flown = spec.mission.name if spec.mission is not None else "missions" if spec.flies_missions else "survey"
    found = [
        ("flown", flown),
        ("scenario", "several" if "scenario" in spec.vary else os.path.basename(spec.scenario)),  # noqa: PTH119
        ("method", spec.method.replace("_", " ")),
        ("runs", f"{count:,}"),
        ("varied", ", ".join(rows.varied) or "nothing"),
        ("poses by", spec.estimate),
    ]
    return found + ([("build", str(rows.rows[0]["build"]))] if rows.rows else [])


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
