"""Sonar levels as grey-scale pictures."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from uwsim.base.atomic_file import write_atomically

Levels = NDArray[np.float32]


def write_grey_png(path: Path, level_db: Levels, limits_db: tuple[float, float]) -> None:
    """Write levels (rows, columns) as an 8-bit grey PNG, one pixel per cell, atomically. NaN is black.

    limits_db: the levels shown as 0 and 255, see shown_range. Raises ValueError unless the limits increase, OSError if
    the file cannot be written.
    """
    low, high = limits_db
    if not high > low:
        raise ValueError(f"limits_db = {low}, {high} dB: must increase")
    share = np.nan_to_num((np.asarray(level_db, np.float64) - low) / (high - low), nan=0.0, posinf=1.0, neginf=0.0)
    grey = np.round(np.clip(share, 0.0, 1.0) * 255.0).astype(np.uint8)
    buffer = io.BytesIO()
    Image.fromarray(grey, mode="L").save(buffer, format="PNG")
    write_atomically(path, buffer.getvalue())
