"""A map score as text for tables and reports, and as JSON: SI units, fractions in [0, 1], null for unknown values."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.s44 import ORDERS, share_within


def score_rows(score: MapScore) -> list[tuple[str, str]]:
    """Return a score as rows of (name, value with unit)."""
    seabed = score.seabed
    return [
        ("coverage", coverage_text(score)),
        ("recall of visible voxels", recall_text(score)),
        ("precision of occupied voxels", percentage(score.precision)),
        ("map to true surface, mean", distance_text(score.distance_mean_m)),
        ("map to true surface, 95th percentile", distance_text(score.distance_p95_m)),
        ("map to true surface, max", distance_text(score.distance_max_m)),
        ("seabed depth error, mean (+: too deep)", distance_text(seabed.mean_m if seabed else math.nan)),
        ("seabed depth error, 95th percentile", distance_text(seabed.p95_m if seabed else math.nan)),
        ("vertical order of IHO S-44", order_met(score)),
    ]


def order_rows(score: MapScore) -> list[tuple[str, str, str]]:
    """Return (order, vertical uncertainty limit at the median depth, fraction of cells within their own limit)."""
    seabed = score.seabed
    if seabed is None or not seabed.judged.any():
        return []
    median_m = np.array([np.median(seabed.depths_m)])
    return [
        (
            order.name,
            distance_text(order.tvu_m(median_m)[0]),
            percentage(share_within(order, seabed.errors_m, seabed.depths_m)),
        )
        for order in ORDERS
    ]


def order_met(score: MapScore) -> str:
    """Return the name of the strictest order whose vertical uncertainty limit is met by 95 % of the seabed cells."""
    if score.seabed is None or not score.seabed.judged.any():
        return "-"
    order = score.seabed.best_order
    return "none" if order is None else order.name


def distance_text(distance_m: float) -> str:
    """Return a distance in metres to the millimetre, or a dash for NaN."""
    return "-" if math.isnan(distance_m) else f"{distance_m:.3f} m"


def percentage(share: float) -> str:
    """Return a fraction in per cent, rounded down so that only 1 is shown as 100 %, or a dash for NaN."""
    return "-" if math.isnan(share) else f"{math.floor(share * 1000.0 + 1e-9) / 10.0:.1f} %"


def recall_text(score: MapScore) -> str:
    """Return recall in per cent, and the share that counts because the surface lies on the voxels' faces, if any."""
    if score.visible_truth_voxels == 0:
        return "-"
    across = score.recalled_across_faces / score.visible_truth_voxels
    return percentage(score.recall) + (f", of which {percentage(across)} across a face" if across >= 1e-3 else "")


def coverage_text(score: MapScore) -> str:
    """Return coverage in per cent of the visible voxels, rounded down so that only 1 is shown as 100 %."""
    if score.visible_truth_voxels == 0:
        return "- (no true surface was visible)"
    return f"{math.floor(score.coverage * 1000.0) / 10.0:.1f} % of {score.visible_truth_voxels:,} voxels"


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
