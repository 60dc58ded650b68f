"""Figures for an exercise: the track with its goals, and the deviations from the values to be held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.figures.flight import ALARM, draw_curves, draw_track

KINDS = {"limit": ("x", ALARM, "limit broken"), "event": ("^", "#f4a300", "event")}


def draw_exercise_track(
    path: Path,
    world: _core.FixedWorld | _core.World,
    track_world_m: NDArray[np.float64],
    places_world_m: Mapping[str, Sequence[tuple[float, ...]]],
    marks: Sequence[tuple[str, float, float]],
) -> None:
    """Draw a track (n, 3) with the goals' points by name, and marks (kind, x, y). Raises OSError."""
    draw_track(
        path, world, {"vehicle": track_world_m}, {},
        places_world_m={name: np.array(points, np.float64)[:, :2] for name, points in places_world_m.items()},
        marks=[(*KINDS[kind], x, y) for kind, x, y in marks],
    )  # fmt: skip


def draw_errors(path: Path, errors: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]]) -> None:
    """Draw distances [m] over times [s], (n,) each, by title. Raises OSError."""
    draw_curves(path, "Errors", "distance [m]", errors)
