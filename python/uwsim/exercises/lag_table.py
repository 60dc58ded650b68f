"""Joins score sheets at several lags or of several seeds to one table, and those of lags to one figure."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import require_own
from uwsim.exercises.certified import read_sheet
from uwsim.exercises.sheet import SCORE

LAGS, SEEDS = "lags", "seeds"
NOT_NAMED = "not named"


def sheets_in(folders: Iterable[Path]) -> list[Path]:
    """Return the files score.json in folders and the folders below them, in order. Raises ValueError without any."""
    found = []
    for folder in folders:
        inside = sorted(folder.rglob(SCORE)) if folder.is_dir() else []
        if not inside:
            raise ValueError(f"--join {folder}: must be a folder with score sheets, {SCORE}")
        found += inside
    return list(dict.fromkeys(found))


def lag_rows(paths: Sequence[Path]) -> list[dict[str, Any]]:
    """Return a row for each sheet, by exercise, pilot, lag and date. Raises OSError or ValueError."""
    rows = []
    for path in paths:
        sheet = read_sheet(path)
        if not isinstance(sheet.get("lag_s"), int | float):
            raise ValueError(f"'{path}': has no lag_s: it was written by an earlier version of uwsim")
        errors = [goal["error_mean_m"] for goal in sheet["goals"] if "error_mean_m" in goal]
        rows.append({
            "exercise": sheet["title"], "pilot": _pilot(sheet), "is_script": bool(sheet["script"]),
            "lag_s": float(sheet["lag_s"]), "score": sheet["score"], "points": sheet["points"],
            "passed": sheet["has_passed"], "valid": sheet["is_valid"], "time_s": sheet["time_s"],
            "limits_broken": sum(limit["broken"] for limit in sheet["limits"]),
            "error_mean_m": float(np.mean(errors)) if errors else None,
            "scenario": sheet["scenario"], "seed": sheet["seed"], "attempt": sheet["attempt"], "date": sheet["date"],
            "build": sheet["build"], "digest": sheet["digest"], "sheet": str(path),
        })  # fmt: skip
    return sorted(rows, key=lambda row: (row["exercise"], row["pilot"], row["lag_s"], row["date"], row["sheet"]))


def _pilot(sheet: Mapping[str, Any]) -> str:
    script = f"script {sheet['script']}" if sheet["script"] else ""
    return ", ".join(each for each in (sheet["person"], script) if each) or NOT_NAMED


def write_table(out: Path, rows: Sequence[Mapping[str, Any]], stem: str) -> list[Path]:
    """Write the rows as stem.csv and stem.json, for LAGS also as lags.png; return their paths. Raises OSError."""
    out.mkdir(parents=True, exist_ok=True)
    table_path, values_path, *figure_path = [
        out / f"{stem}.{suffix}" for suffix in ("csv", "json", *(("png",) if stem == LAGS else ()))
    ]
    for path in (table_path, values_path, *figure_path):
        require_own(path)
    text = io.StringIO()
    table = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    write_atomically(table_path, text.getvalue().encode())
    write_atomically(values_path, (json.dumps(list(rows), indent=1, allow_nan=False) + "\n").encode())
    for path in figure_path:
        _draw(path, rows)
    return [table_path, values_path, *figure_path]


def mean_interval(values: Sequence[float]) -> tuple[float, float]:
    """Return the mean of some values, and half the width of its 95 % interval by Student's t; 0 for one value."""
    from scipy.stats import t

    found = np.array(values, np.float64)
    if len(found) < 2:
        return float(found.mean()), 0.0
    return float(found.mean()), float(t.ppf(0.975, len(found) - 1) * found.std(ddof=1) / np.sqrt(len(found)))


def mean_score(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the mean score of several attempts in words, with its 95 % interval by Student's t."""
    mean, half = mean_interval([row["score"] for row in rows])
    low, high = max(mean - half, 0.0), min(mean + half, rows[0]["points"])
    passed = sum(bool(row["passed"]) for row in rows)
    return (
        f"{len(rows)} seeds: {mean:.1f} of {rows[0]['points']:g} on average, 95 % interval "
        f"{low:.1f} to {high:.1f}; {passed} passed"
    )


def _draw(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Draw score and duration against the lag: each valid attempt, and a line through the means of each pilot."""
    from uwsim.figures.style import INK, label_axes, new_figure, save_figure

    figure = new_figure(11.0, 4.6)
    left, right = (figure.add_axes((x, 0.14, 0.38, 0.74)) for x in (0.07, 0.55))
    series = sorted({(row["exercise"], row["pilot"]) for row in rows})
    several = len({exercise for exercise, _ in series}) > 1
    for k, (exercise, pilot) in enumerate(series):
        own = [row for row in rows if (row["exercise"], row["pilot"]) == (exercise, pilot) and row["valid"]]
        lags = sorted({row["lag_s"] for row in own})
        colour, name = f"C{k}", f"{exercise}: {pilot}" if several else pilot
        for axes, value in ((left, _share), (right, _time)):
            axes.plot([row["lag_s"] for row in own], [value(row) for row in own], "o", color=colour, markersize=4)
            means = [float(np.mean([value(row) for row in own if row["lag_s"] == lag])) for lag in lags]
            axes.plot(lags, means, "-", color=colour, linewidth=1.4, label=f"{name} ({len(own)})")
    titles = "" if several else f" in “{series[0][0]}”"
    label_axes(left, f"Score{titles}", "lag, one way [s]", "share of the points [%]")
    label_axes(right, "Duration", "lag, one way [s]", "time until the end [s]")
    left.set_ylim(-3.0, 103.0)
    right.set_ylim(bottom=0.0)
    left.legend(fontsize=8, frameon=False, labelcolor=INK)
    save_figure(figure, path)


def _share(row: Mapping[str, Any]) -> float:
    return float(100.0 * row["score"] / row["points"])


def _time(row: Mapping[str, Any]) -> float:
    return float(row["time_s"])
