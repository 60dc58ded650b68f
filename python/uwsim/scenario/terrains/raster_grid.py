"""An elevation raster as it is in its file: its cells, and where they are on Earth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from affine import Affine
from numpy.typing import NDArray
from rasterio.crs import CRS
from rasterio.warp import transform

from uwsim.mapping.files.georeference import WGS84, metres_about
from uwsim.scenario.read.errors import ScenarioError

FloatGrid = NDArray[np.float64]
Coordinates = TypeVar("Coordinates", float, FloatGrid)
TRUE_TO_SCALE = 1e-3
"""A projection whose scale is within this share of 1, as those of surveys are, has metres that count as real ones."""


def mapped(affine: Affine, x: Coordinates, y: Coordinates) -> tuple[Coordinates, Coordinates]:
    """Return an affine map of coordinates."""
    return affine.a * x + affine.b * y + affine.c, affine.d * x + affine.e * y + affine.f


@dataclass(frozen=True)
class Raster:
    """A raster read from a file.

    elevations: (h, w) [m]; NaN for cells without data. file_from_pixel: transform from pixel corners (column, row) to
    the file's coordinates. names_crs: whether the file or the scenario does; without it, crs is a guess.
    """

    name: str
    elevations: FloatGrid
    file_from_pixel: Affine
    crs: CRS | None
    names_crs: bool = True

    @property
    def unit_m(self) -> float:
        """Metres per unit of a projected coordinate system, whose unit may be feet; 1 for others."""
        return float(self.crs.linear_units_factor[1]) if self.crs is not None and self.crs.is_projected else 1.0

    @property
    def is_geographic(self) -> bool:
        """Whether the coordinates are longitude and latitude in degrees."""
        return self.crs is not None and bool(self.crs.is_geographic)

    def metres_about(self, centre: tuple[float, float]) -> CRS | None:
        """Return the projection to metres about a place, or None where the file's own coordinates are true to scale."""
        if self.crs is None:
            return None
        if self.is_geographic:
            return metres_about(centre)
        longitude, latitude = (float(each[0]) for each in transform(self.crs, WGS84, [centre[0]], [centre[1]]))
        if not np.isfinite([longitude, latitude]).all():
            raise ScenarioError(
                f"terrain.centre = ({centre[0]:.9g}, {centre[1]:.9g}): '{self.name}' has no longitude there",
                at=("centre",),
            )
        about, step = metres_about((longitude, latitude)), 100.0 / self.unit_m
        x, y = transform(self.crs, about, centre[0] + step * np.eye(3)[0], centre[1] + step * np.eye(3)[1])
        sides = np.array([np.subtract(each[:2], each[2]) for each in (x, y)]) / 100.0
        true = np.abs(np.linalg.svd(sides, compute_uv=False) - 1.0).max() <= TRUE_TO_SCALE
        return None if true else about

    def safe_cell_m(self, centre: tuple[float, float]) -> float:
        """Return the largest edge [m] such that a square of n of them lies within n x n cells about a place."""
        about, unit = self.metres_about(centre), self.unit_m
        column, row = self.corner_at(*centre)
        x, y = self.place_at(column + np.eye(3)[0], row + np.eye(3)[1])
        east, north = (unit * x, unit * y) if about is None else transform(self.crs, about, x, y)
        sides = np.array([np.subtract(each[:2], each[2]) for each in (east, north)])
        return 1.0 / float(np.abs(np.linalg.inv(sides)).sum(axis=1).max())

    def pixel_at(self, x: FloatGrid, y: FloatGrid) -> tuple[FloatGrid, FloatGrid]:
        """Convert the file's coordinates to fractional columns and rows; whole numbers are cell centres."""
        columns, rows = mapped(~self.file_from_pixel, x, y)
        return columns - 0.5, rows - 0.5

    def corner_at(self, x: float, y: float) -> tuple[float, float]:
        """Convert the file's coordinates to fractional columns and rows; whole numbers are corners of cells."""
        return mapped(~self.file_from_pixel, x, y)

    def place_at(self, column: Coordinates, row: Coordinates) -> tuple[Coordinates, Coordinates]:
        """Convert columns and rows, as of `corner_at`, to the file's coordinates."""
        return mapped(self.file_from_pixel, column, row)
