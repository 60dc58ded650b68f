"""The bed of a Unity scene as a grid of heights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core

SPACING_M, ABOVE_M, DEEP_M, BED_MAX_M = 0.5, 1e3, 1e4, 2000.0


@dataclass(frozen=True)
class Bed:
    """heights_m: (rows, columns), from north to south and from west to east, about the origin.

    fill_m: the height where the scene has no bed.
    """

    heights_m: NDArray[np.float64]
    fill_m: float

    @property
    def reach_m(self) -> float:
        """The greatest x and y with a height."""
        return SPACING_M * (len(self.heights_m) - 1) / 2.0

    @property
    def text(self) -> bytes:
        """An ESRI grid."""
        count, edge = len(self.heights_m), -SPACING_M * len(self.heights_m) / 2.0
        head = f"ncols {count}\nnrows {count}\nxllcorner {edge}\nyllcorner {edge}\ncellsize {SPACING_M}\n"
        row_text = " ".join(["%.3f"] * count) + "\n"
        return (head + "".join(row_text % tuple(row) for row in self.heights_m.tolist())).encode()

    def reaches(self, x_m: float, y_m: float) -> bool:
        """Return whether there is a height at a place."""
        return bool(max(abs(x_m), abs(y_m)) <= self.reach_m)

    def is_under(self, x_m: float, y_m: float) -> bool:
        """Return whether there is water over the bed at a place."""
        if not self.reaches(x_m, y_m):
            return False
        row, column = np.rint((self.reach_m + np.array([-y_m, x_m])) / SPACING_M).astype(int)
        return bool(self.heights_m[row, column] < 0.0)

    def open_water(self) -> tuple[float, float, float]:
        """Return the bed's point next to the origin among those with half of the greatest depth or more.

        Raises ValueError for a bed that is above the water everywhere.
        """
        if (lowest_m := float(self.heights_m.min())) >= 0.0:
            raise ValueError(f"the bed's lowest point is {lowest_m:.1f} m above the water: it must be below")
        rows, columns = np.nonzero(self.heights_m <= 0.5 * lowest_m)
        x_m, y_m = SPACING_M * columns - self.reach_m, self.reach_m - SPACING_M * rows
        near = int(np.argmin(x_m**2 + y_m**2))
        return float(x_m[near]), float(y_m[near]), float(self.heights_m[rows[near], columns[near]])


def read_bed(surface: tuple[NDArray[np.float64], NDArray[np.int64]], size_m: float | None = None) -> Bed:
    """Return the highest surface of vertices (n, 3) in uwsim's world [m] and triangles (m, 3). Raises ValueError.

    size_m: the largest edge of the grid, about the origin; by default it reaches as far as the surface.
    """
    if size_m is not None and size_m > BED_MAX_M:
        raise ValueError(f"--size = {size_m:g} m: must be at most {BED_MAX_M:g} m for the bed of a Unity project")
    vertices, triangles = surface
    world = _core.World()
    world.add_solid("bed", vertices, triangles.astype(np.uint32))
    wide_m = 2.0 * float(np.abs(vertices[:, :2]).max())
    if size_m is not None:
        wide_m = min(wide_m, size_m)
    if wide_m > BED_MAX_M:
        raise ValueError(
            f"the bed needs a grid about the origin {wide_m:.0f} m wide: must be at most {BED_MAX_M:g} m; "
            "--size makes a part of it the bed"
        )
    half = SPACING_M * np.ceil(0.5 * wide_m / SPACING_M)
    places = np.arange(-half, half, SPACING_M) + SPACING_M / 2.0
    east, north = np.meshgrid(places, places[::-1])
    above = np.stack([east.ravel(), north.ravel(), np.full(east.size, vertices[:, 2].max() + ABOVE_M)], axis=1)
    ranges = _core.RayScene(world).cast(above, np.array([[0.0, 0.0, -1.0]]).repeat(len(above), 0), DEEP_M).ranges_m
    heights = above[:, 2] - ranges
    if not np.isfinite(heights).any():
        raise ValueError("the bed has no surface that can be seen from above")
    fill_m = float(heights[np.isfinite(heights)].min())
    return Bed(np.where(np.isfinite(heights), heights, fill_m).reshape(east.shape), fill_m)
