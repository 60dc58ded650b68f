"""Joins the score sheets of several seeds to one table."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import require_own
from uwsim.exercises.certified import read_sheet

NAMES = ("seeds.csv", "seeds.json")
NOT_NAMED = "not named"


def seed_row(path: Path) -> dict[str, Any]:
    """Return the row of a sheet, score.json. Raises OSError or ValueError."""
    sheet = read_sheet(path)
    errors = [goal["error_mean_m"] for goal in sheet["goals"] if "error_mean_m" in goal]
    return {
        "exercise": sheet["title"], "pilot": _pilot(sheet), "score": sheet["score"], "points": sheet["points"],
        "passed": sheet["has_passed"], "valid": sheet["is_valid"], "time_s": sheet["time_s"],
        "limits_broken": sum(limit["broken"] for limit in sheet["limits"]),
        "error_mean_m": float(np.mean(errors)) if errors else None,
        "scenario": sheet["scenario"], "seed": sheet["seed"], "date": sheet["date"], "build": sheet["build"],
        "digest": sheet["digest"], "sheet": str(path),
    }  # fmt: skip


def _pilot(sheet: Mapping[str, Any]) -> str:
    script = f"script {sheet['script']}" if sheet["script"] else ""
    return ", ".join(each for each in (sheet["person"], script) if each) or NOT_NAMED


def write_table(out: Path, rows: Sequence[Mapping[str, Any]]) -> list[Path]:
    """Write the rows as NAMES into a folder; return their paths. Raises OSError."""
    table_path, values_path = (out / name for name in NAMES)
    for path in (table_path, values_path):
        require_own(path)
    text = io.StringIO()
    table = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    write_atomically(table_path, text.getvalue().encode())
    write_atomically(values_path, (json.dumps(list(rows), indent=1, allow_nan=False) + "\n").encode())
    return [table_path, values_path]


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
