"""The bed of a model of structure from motion: its points, or those of a dense cloud or mesh beside it, as a grid."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from uwsim.evidence.photos.placement import Placement
from uwsim.evidence.photos.reconstruction import Floats, Reconstruction
from uwsim.evidence.soundings import REACH, default_cell, scattered

DENSE = ("meshed-delaunay.ply", "meshed-poisson.ply", "fused.ply")
"""Files of COLMAP's dense reconstruction, in the sparse model's axes: the first that is found is gridded."""
PERCENT, CELL_MIN_M = 1.0, 0.02
"""Points beyond these percentiles of east or north are left out: a few are always far away."""
MARGIN_M = 8.0
"""Assumed: the bed goes on so far around the points, at the height of the nearest, for a vehicle to turn."""


@dataclass(frozen=True)
class Bed:
    """heights_m: (rows, columns), from the north, at nodes cell_m apart about the origin. known: where points are near.

    origin_m: (2,), the world's origin in the axes of the placement. points_m: those that were gridded, from there.
    """

    heights_m: Floats
    cell_m: float
    origin_m: Floats
    points_m: Floats
    half_m: Floats
    notes: list[str]


def dense_beside(folder: Path) -> Path | None:
    """Return the dense cloud or mesh in a model's folder, in one above it, or in their folder dense."""
    above = [folder, *folder.resolve().parents[:2]]
    places = [each / sub for each in above for sub in ("", "dense", "dense/0")]
    return next((place / name for place in places for name in DENSE if (place / name).is_file()), None)


def read_bed(model: Reconstruction, placement: Placement, cell_m: float | None) -> Bed:
    """Return the bed under a model. cell_m: the width of a cell, by default by density. Raises ValueError."""
    dense, notes = dense_beside(model.path), []
    if dense is None:
        points = placement.placed(model.points)
        what = "the sparse points"
    else:
        from uwsim.mapping.files.cloud_files import read_cloud

        points = placement.placed(read_cloud(dense))
        what = f"the {len(points)} points of '{dense}'"
    low, high = np.percentile(points[:, :2], [PERCENT, 100.0 - PERCENT], axis=0)
    inside = ((points[:, :2] >= low) & (points[:, :2] <= high)).all(axis=1)
    beyond = f"{len(points) - inside.sum()} of {len(points)} points"
    notes.append(f"left out: {beyond}, the outermost {PERCENT:g} % of each side")
    points = points[inside]
    if len(points) < 9 or (np.ptp(points[:, :2], axis=0) < 3.0 * CELL_MIN_M).any():
        east, north = np.ptp(points[:, :2], axis=0)
        rule = f"must be 9 or more, over {3.0 * CELL_MIN_M:g} m or more each way: --scale"
        raise ValueError(f"'{model.path}': {len(points)} points over {east:.3g} x {north:.3g} m: {rule}")
    x, y = points[:, 0], points[:, 1]
    cell = float(f"{max(CELL_MIN_M, default_cell(x, y, 1.0)):.3g}") if cell_m is None else cell_m
    heights = scattered(model.path, points, cell, cell)
    rows, columns = heights.shape
    origin = np.array([x.min() + 0.5 * (columns - 1) * cell, y.max() - 0.5 * (rows - 1) * cell])
    known = np.isfinite(heights)
    notes.append(
        f"the bed is a grid of {what}: the median of each cell of {cell:g} m, gaps up to {REACH:g} cells "
        "interpolated linearly"
    )
    heights = _extended(heights, int(np.ceil(MARGIN_M / cell)))
    share = f"{100.0 * (1.0 - known.mean()):.0f} % of the bed among the points"
    notes.append(f"assumed: {share}, and {MARGIN_M:g} m around them, have the height of the nearest")
    half = 0.5 * cell * (np.array([columns, rows]) - 1)
    return Bed(heights, cell, origin, points - [*origin, 0.0], half, notes)


def _extended(heights: Floats, margin: int) -> Floats:
    """Return a grid that goes on by a margin of cells, whose unknown heights are those of the nearest known cells."""
    from scipy.ndimage import distance_transform_edt

    padded = np.pad(heights, margin, constant_values=np.nan)
    nearest = distance_transform_edt(np.isnan(padded), return_distances=False, return_indices=True)
    return np.asarray(padded[tuple(nearest)])
