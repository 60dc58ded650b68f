"""Where a film's camera is: behind a vehicle, around it, or on a path of the user's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

from uwsim.base.arrays import Floats
from uwsim.base.quaternions import heading_rad, of_yaw_pitch_roll_deg
from uwsim.base.texts.csv_table import read_csv
from uwsim.simulator.simulator import Simulator

BEHIND_M, ABOVE_M, AROUND_M = 2.6, 0.9, 3.2
"""Distances of the cameras `chase` and `orbit` from the vehicle."""
AHEAD_M = 1.5
"""How far ahead of the vehicle the camera `chase` looks."""
STEADY_S = 0.6
"""Standard deviation of the Gaussian in time that steadies the camera `chase`."""
TURN_S = 30.0
"""Time in which the camera `orbit` goes around once."""
CLEAR_M = 0.3
"""Least distance from the bed, from what is between the vehicle and the camera, and from the surface."""
PATH = ("time_s", "x_m", "y_m", "z_m", "at_x_m", "at_y_m", "at_z_m")


def chase(sim: Simulator, positions_m: Floats, orientations_xyzw: Floats, fps: float) -> Floats:
    """Return poses (n, 7) behind and above a vehicle, which lag neither way."""
    yaw = np.unwrap([heading_rad(orientation) for orientation in orientations_xyzw])
    yaw = gaussian_filter1d(yaw, STEADY_S * fps, mode="nearest")
    middle = gaussian_filter1d(positions_m, 0.5 * STEADY_S * fps, axis=0, mode="nearest")
    ahead = np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=1)
    return _looking(
        _kept_clear(sim, middle, middle - BEHIND_M * ahead + [0, 0, ABOVE_M], fps), middle + AHEAD_M * ahead
    )


def orbit(sim: Simulator, positions_m: Floats, fps: float) -> Floats:
    """Return poses (n, 7) around a vehicle."""
    middle = gaussian_filter1d(positions_m, 0.5 * STEADY_S * fps, axis=0, mode="nearest")
    turn = 2 * np.pi * np.arange(len(middle)) / (fps * TURN_S)
    out = np.stack([np.cos(turn), np.sin(turn), np.full_like(turn, 0.25)], axis=1)
    return _looking(_kept_clear(sim, middle, middle + AROUND_M * out, fps), middle)


def along_path(path: Path, times_s: Floats) -> Floats:
    """Return poses (n, 7) at times of the run, between the rows of a CSV file with the columns PATH.

    Raises ValueError or OSError.
    """
    table = read_csv(path)
    columns = [table.numbers(name) for name in PATH]
    if len(table) < 1 or (np.diff(columns[0]) <= 0).any():
        raise ValueError(f"'{path}': must have rows with times that ascend")
    x, y, z, at_x, at_y, at_z = (np.interp(times_s, columns[0], column) for column in columns[1:])
    return _looking(np.stack([x, y, z], axis=1), np.stack([at_x, at_y, at_z], axis=1))


def _kept_clear(sim: Simulator, middle: Floats, eyes: Floats, fps: float) -> Floats:
    """Return eyes (n, 3) that the vehicle at middle (n, 3) can be seen from, above the bed and below the surface."""
    lines = eyes - middle
    reach = np.linalg.norm(lines, axis=1)
    hit = np.array(
        [
            sim.scene.cast(a[None], b[None], r + CLEAR_M).ranges_m[0]
            for a, b, r in zip(middle, lines, reach, strict=True)
        ]
    )
    share = np.clip((np.where(np.isfinite(hit), hit, np.inf) - CLEAR_M) / reach, 0.2, 1.0)
    share = np.minimum(gaussian_filter1d(share, 0.5 * STEADY_S * fps, mode="nearest"), share)
    eyes = middle + share[:, None] * lines
    bed = sim.world.height_at(eyes[:, :2])
    eyes[:, 2] = np.maximum(np.minimum(eyes[:, 2], -CLEAR_M), np.where(np.isfinite(bed), bed, -np.inf) + CLEAR_M)
    return eyes


def _looking(eyes: Floats, at: Floats) -> Floats:
    """Return poses (n, 7) at eyes (n, 3) that look at points (n, 3), level."""
    x, y, z = (at - eyes).T
    yaw, pitch = np.degrees(np.arctan2(y, x)), np.degrees(np.arctan2(-z, np.hypot(x, y)))
    turns = [of_yaw_pitch_roll_deg((float(a), float(b), 0.0)) for a, b in zip(yaw, pitch, strict=True)]
    return np.column_stack([eyes, turns])
