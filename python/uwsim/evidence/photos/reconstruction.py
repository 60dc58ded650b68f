"""A model of structure from motion: pictures with their poses, points with their colours, and which sees which."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

PIXELS_MAX, TRACK_MIN, SPREAD_MIN_DEG = 2.0, 3, 5.0
"""A point is kept if it is seen in TRACK_MIN pictures, from directions SPREAD_MIN_DEG apart, within PIXELS_MAX."""


@dataclass(frozen=True)
class Reconstruction:
    """A model, in its own axes and unit.

    pictures: their names. sizes: (k, 2), their widths and heights. centres: (k, 3) of the cameras. turns: (k, 3, 3),
    rotations from a camera's optical frame. points: (n, 3). errors: (n,) [pixels]. seen_in, seen_point: (m,), indices
    of picture and point of each observation. seen_at: (m, 2) [pixels]; the corner of the upper left pixel is (0, 0).
    notes: a line for each that was read or left out.
    """

    path: Path
    pictures: list[str]
    sizes: Indices
    centres: Floats
    turns: Floats
    points: Floats
    errors: Floats
    seen_in: Indices
    seen_point: Indices
    seen_at: Floats
    notes: list[str] = field(default_factory=list)

    def reliable(self) -> Reconstruction:
        """Return it with the points that are well determined alone, and note how many. Raises ValueError for none."""
        rays = self.points[self.seen_point] - self.centres[self.seen_in]
        rays = rays / np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), 1e-300)
        count = np.bincount(self.seen_point, minlength=len(self.points))
        mean = np.column_stack([np.bincount(self.seen_point, ray, len(self.points)) for ray in rays.T])
        mean = mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
        off = np.arccos(np.clip(np.einsum("ij,ij->i", rays, mean[self.seen_point]), -1.0, 1.0))
        widest = np.zeros(len(self.points))
        np.maximum.at(widest, self.seen_point, off)
        kept = (count >= TRACK_MIN) & (2.0 * widest >= np.radians(SPREAD_MIN_DEG)) & ~(self.errors > PIXELS_MAX)
        if not kept.any():
            raise ValueError(
                f"'{self.path}': has no point that is seen in {TRACK_MIN} pictures, from directions "
                f"{SPREAD_MIN_DEG:g} deg apart, within {PIXELS_MAX:g} pixels"
            )
        index, own = np.cumsum(kept) - 1, kept[self.seen_point]
        left = (
            f"left out: {len(kept) - kept.sum()} of {len(kept)} points: seen in fewer than {TRACK_MIN} pictures, from "
            f"directions less than {SPREAD_MIN_DEG:g} deg apart, or more than {PIXELS_MAX:g} pixels off"
        )
        return replace(
            self,
            points=self.points[kept],
            errors=self.errors[kept],
            seen_in=self.seen_in[own],
            seen_point=index[self.seen_point[own]],
            seen_at=self.seen_at[own],
            notes=[*self.notes, *([] if kept.all() else [left])],
        )
