"""Pictures of a forward-looking sonar: from range and bearing to pixels in its plane, and from levels to greys."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import map_coordinates, uniform_filter1d

from uwsim.atomic_file import write_atomically
from uwsim.sonars.imaging import SonarImage

Levels = NDArray[np.float32]

BELOW_MEDIAN_DB, ABOVE_MEDIAN_DB = 13.0, 12.0
ECHO_OVER_NOISE_DB = 6.0
MIN_ECHO_SHARE = 0.02
DARK_DB = 10.0


@dataclass(frozen=True, eq=False)
class FanPixels:
    """An image in the sonar's plane.

    level_db: (height, width) float32, NaN outside the fan; the first row is the farthest ahead, the first column the
    farthest to port. extent_m: left, right, bottom, top; right is starboard, up is ahead.
    """

    level_db: Levels
    extent_m: tuple[float, float, float, float]


def fan_pixels(image: SonarImage, height: int = 900) -> FanPixels:
    """Warp a forward-looking picture (ranges, bearings) into its plane. Raises ValueError unless height is positive.

    Power is averaged over the range bins that a pixel covers, then interpolated between four neighbours.
    """
    if height < 1:
        raise ValueError(f"height = {height} pixels: must be positive")
    reach, half = image.model.range_max_m, image.model.field_of_view_rad / 2
    side = reach * (np.sin(half) if half < np.pi / 2 else 1.0)
    back = min(reach * float(np.cos(half)), 0.0)
    pixel_m = (reach - back) / height
    width = max(int(np.ceil(2 * side / pixel_m)), 1)
    ahead, port = np.meshgrid(
        reach - (np.arange(height) + 0.5) * pixel_m, side - (np.arange(width) + 0.5) * (2 * side / width), indexing="ij"
    )
    ranges, bearings = np.hypot(ahead, port), np.arctan2(port, ahead)
    power = 10.0 ** (image.level_db.astype(np.float64) / 10.0)
    power = uniform_filter1d(power, max(round(pixel_m / image.model.bin_m), 1), axis=0, mode="nearest")
    beams = image.model.beams
    per_rad = (beams - 1) / image.model.field_of_view_rad if beams > 1 else 0.0
    places = [ranges / image.model.bin_m - 0.5, (bearings + half) * per_rad]
    warped = map_coordinates(power, places, order=1, mode="nearest")
    level_db = np.where((ranges <= reach) & (np.abs(bearings) <= half), 10.0 * np.log10(warped), np.nan)
    return FanPixels(level_db.astype(np.float32), (-side, side, back, reach))


def shown_range(level_db: Levels, noise_db: Levels) -> tuple[float, float]:
    """Return the levels of black and white, as an operator would set them: about the median of the echoes.

    level_db, noise_db: of shapes that broadcast. Shadows, which contain only noise, are dark; hard targets saturate.
    Without enough echoes, noise stays near black.
    """
    over_db = level_db - noise_db
    echoes = level_db[np.isfinite(level_db) & (over_db > ECHO_OVER_NOISE_DB)]
    enough = echoes.size > MIN_ECHO_SHARE * level_db.size
    middle = float(np.median(echoes)) if enough else float(np.max(noise_db)) + DARK_DB
    return middle - BELOW_MEDIAN_DB, middle + ABOVE_MEDIAN_DB


def write_grey_png(path: Path, level_db: Levels, limits_db: tuple[float, float]) -> None:
    """Write levels (rows, columns) as an 8-bit grey PNG, one pixel for each cell, atomically. NaN is black.

    limits_db: the levels of 0 and 255, see shown_range. Raises OSError; ValueError unless the limits increase.
    """
    low, high = limits_db
    if not high > low:
        raise ValueError(f"limits_db = {low}, {high} dB: must increase")
    share = np.nan_to_num((np.asarray(level_db, np.float64) - low) / (high - low), nan=0.0, posinf=1.0, neginf=0.0)
    grey = np.round(np.clip(share, 0.0, 1.0) * 255.0).astype(np.uint8)
    buffer = io.BytesIO()
    Image.fromarray(grey, mode="L").save(buffer, format="PNG")
    write_atomically(path, buffer.getvalue())
