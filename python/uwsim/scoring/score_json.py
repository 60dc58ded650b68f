"""A map score as JSON: SI units, fractions in [0, 1], null for unknown values."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.s44 import ORDERS, share_within


def score_values(score: MapScore, *, path_known: bool) -> dict[str, Any]:
    """Return score values by name. path_known: whether there is a path; coverage and recall require one."""
    seabed = score.seabed
    known = path_known and score.visible_truth_voxels > 0
    figures: dict[str, Any] = {
        "occupied_voxels": score.occupied_voxels,
        "false_voxels": len(score.false_centres_m),
        "precision": score.precision,
        "visible_truth_voxels": score.visible_truth_voxels if path_known else None,
        "coverage": score.coverage if known else None,
        "recall": score.recall if known else None,
        "recalled_across_faces": score.recalled_across_faces if known else None,
        "distance_mean_m": score.distance_mean_m,
        "distance_p95_m": score.distance_p95_m,
        "distance_max_m": score.distance_max_m,
        "resolution_m": score.resolution_m,
    }
    if seabed is not None:
        best = seabed.best_order
        figures |= {
            "seabed_cells": int(seabed.judged.sum()),
            "seabed_obstructed_cells": int(seabed.obstructed.sum()),
            "seabed_error_mean_m": seabed.mean_m,
            "seabed_error_p95_m": seabed.p95_m,
            "s44_order": best.name if best is not None else None,
        }
        errors, depths = seabed.errors_m, seabed.depths_m
        figures |= {f"s44_share_{order.name.lower()}": share_within(order, errors, depths) for order in ORDERS}
    return figures


def write_json(path: Path, values: Mapping[str, Any]) -> None:
    """Write values atomically; NaN becomes null. Raises OSError."""
    plain = {name: None if isinstance(v, float) and math.isnan(v) else v for name, v in values.items()}
    write_atomically(path, (json.dumps(plain, indent=2) + "\n").encode("utf-8"))
