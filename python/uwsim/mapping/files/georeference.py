"""The location of a world on Earth, for files of depth grids."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # rasterio takes half a second to import
    from rasterio.crs import CRS


@dataclass(frozen=True)
class Georeference:
    """The world's location on Earth: its origin in a coordinate system, and that system's units per simulated metre.

    crs: None for a world without a location on Earth; files then use metres east and north of the world's origin.
    """

    crs: CRS | None = None
    origin: tuple[float, float] = (0.0, 0.0)
    units_per_m: float = 1.0
