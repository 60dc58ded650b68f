"""Converts levels by range and bearing to pixels in the sonar's plane, and levels to display colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Levels = NDArray[np.float32]

BELOW_MEDIAN_DB, ABOVE_MEDIAN_DB = 13.0, 12.0
ECHO_OVER_NOISE_DB = 6.0
MIN_ECHO_SHARE = 0.02
DARK_DB = 10.0
AMBER = ("#000000", "#4a2503", "#c47a1a", "#ffd98a", "#fffbe8")
"""Colours from the weakest to the strongest level, evenly spaced."""
NIGHT = "#0b0f14"
"""Colour of pixels without a level."""


@dataclass(frozen=True, eq=False)
class FanPixels:
    """An image in the sonar's plane.

    level_db: (height, width) float32, NaN outside the fan; the first row is farthest ahead, the first column farthest
    to port. extent_m: left, right, bottom, top; right is starboard, up is ahead.
    """

    level_db: Levels
    extent_m: tuple[float, float, float, float]


class Fan(Protocol):
    """A picture by range and bearing, such as a SonarImage. model: has range_max_m and field_of_view_rad."""

    @property
    def model(self) -> Any:
        """The sonar's model."""

    @property
    def level_db(self) -> Levels:
        """The levels (ranges, bearings)."""


def fan_pixels(image: Fan, height: int = 900) -> FanPixels:
    """Return a forward-looking picture (ranges, bearings) warped to its plane. Raises ValueError for height <= 0."""
    model = image.model
    return polar_pixels(image.level_db, model.range_max_m, model.field_of_view_rad, height)


def polar_pixels(level_db: Levels, reach_m: float, field_of_view_rad: float, height: int) -> FanPixels:
    """Return levels (bins, beams) warped to their plane.

    Bins divide reach_m evenly; beams run from starboard to port.

    Power is averaged over the range bins within a pixel, then interpolated between four neighbours. Raises ValueError
    unless height is positive.
    """
    from scipy.ndimage import map_coordinates, uniform_filter1d  # slow to import

    if height < 1:
        raise ValueError(f"height = {height} pixels: must be positive")
    bins, beams = level_db.shape
    reach, half, bin_m = reach_m, field_of_view_rad / 2, reach_m / bins
    side = reach * (np.sin(half) if half < np.pi / 2 else 1.0)
    back = min(reach * float(np.cos(half)), 0.0)
    pixel_m = (reach - back) / height
    width = max(int(np.ceil(2 * side / pixel_m)), 1)
    ahead, port = np.meshgrid(
        reach - (np.arange(height) + 0.5) * pixel_m, side - (np.arange(width) + 0.5) * (2 * side / width), indexing="ij"
    )
    ranges, bearings = np.hypot(ahead, port), np.arctan2(port, ahead)
    power = 10.0 ** (level_db.astype(np.float64) / 10.0)
    power = uniform_filter1d(power, max(round(pixel_m / bin_m), 1), axis=0, mode="nearest")
    per_rad = (beams - 1) / field_of_view_rad if beams > 1 else 0.0
    places = [ranges / bin_m - 0.5, (bearings + half) * per_rad]
    warped = map_coordinates(power, places, order=1, mode="nearest")
    inside = (ranges <= reach) & (np.abs(bearings) <= half)
    pixels_db = np.where(inside, 10.0 * np.log10(np.maximum(warped, 1e-30)), np.nan)
    return FanPixels(pixels_db.astype(np.float32), (-side, side, back, reach))


def shown_range(level_db: Levels, noise_db: Levels) -> tuple[float, float]:
    """Return the levels to show as black and white, around the median of the echoes, as an operator would set them.

    level_db, noise_db: arrays whose shapes broadcast. Shadows, which contain only noise, are dark; hard targets
    saturate. Without enough echoes, noise stays near black.
    """
    over_db = level_db - noise_db
    echoes = level_db[np.isfinite(level_db) & (over_db > ECHO_OVER_NOISE_DB)]
    enough = echoes.size > MIN_ECHO_SHARE * level_db.size
    middle = float(np.median(echoes)) if enough else float(np.max(noise_db)) + DARK_DB
    return middle - BELOW_MEDIAN_DB, middle + ABOVE_MEDIAN_DB


def in_colours(level_db: Levels, limits_db: tuple[float, float]) -> NDArray[np.uint8]:
    """Return levels (rows, columns) as AMBER colours (rows, columns, 3); NaN becomes NIGHT.

    limits_db: the levels of the first and last colours, see shown_range.
    """
    low, high = limits_db
    anchors = np.array([_rgb(colour) for colour in AMBER], np.float64)
    share = np.clip((np.nan_to_num(level_db, nan=low) - low) / (high - low), 0.0, 1.0)
    steps = np.linspace(0.0, 1.0, 256)
    table = np.stack([np.interp(steps, np.linspace(0.0, 1.0, len(AMBER)), channel) for channel in anchors.T], axis=1)
    colours: NDArray[np.uint8] = np.round(table).astype(np.uint8)[np.round(255.0 * share).astype(np.uint8)]
    colours[np.isnan(level_db)] = _rgb(NIGHT)
    return colours


def _rgb(colour: str) -> tuple[int, ...]:
    return tuple(bytes.fromhex(colour[1:]))
