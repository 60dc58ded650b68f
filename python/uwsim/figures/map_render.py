"""3D figure of a map in the style of octovis, with a coloured cube for each occupied voxel; needs no display."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from numpy.typing import NDArray

from uwsim.figures.pinhole_view import view_of_box
from uwsim.figures.render_3d import Subject, cast_at_cubes, render
from uwsim.figures.style import HEIGHTS, INK, PIXELS_PER_INCH, height_range, new_figure, save_figure
from uwsim.mapping import OccupancyMap
from uwsim.mapping.info import occupied_cubes

MAX_CUBES = 3_000_000
"""Maximum number of cubes; a map with more voxels is drawn with larger cubes."""
SUN_WORLD = np.array([-0.62, 0.21, 0.76]) / np.linalg.norm([-0.62, 0.21, 0.76])
FOOT_PIXELS = 130
MIN_WIDTH, MAX_WIDTH = 200, 8000


@dataclass(frozen=True)
class Viewpoint:
    """The direction from which a map is drawn, and the width of the picture.

    azimuth_deg: direction from the map centre to the eye, counterclockwise from east. elevation_deg: angle of the eye
    above the horizon. width: in pixels.
    """

    azimuth_deg: float = -118.0
    elevation_deg: float = 38.0
    width: int = 1600

    def __post_init__(self) -> None:
        if not np.isfinite(self.azimuth_deg):
            raise ValueError(f"azimuth = {self.azimuth_deg} deg: must be finite")
        if not -89.0 <= self.elevation_deg <= 89.0:
            raise ValueError(f"elevation = {self.elevation_deg:g} deg: must be in [-89, 89] deg")
        if not MIN_WIDTH <= self.width <= MAX_WIDTH:
            raise ValueError(f"width = {self.width}: must be in [{MIN_WIDTH}, {MAX_WIDTH}] pixels")


def draw_map(path: Path, occupancy: OccupancyMap, viewpoint: Viewpoint, title: str) -> None:
    """Draw a map as a PNG. Raises ValueError if no voxel is occupied, OSError if the file cannot be written."""
    centres, edge_m = occupied_cubes(occupancy, title, MAX_CUBES)
    shift = occupancy.origin_world_m - np.floor(occupancy.origin_world_m / edge_m) * edge_m
    on_grid = centres - shift  # cubes must lie at multiples of their edge length
    heights = height_range(centres[:, 2])
    low, high = on_grid.min(axis=0) - edge_m / 2.0, on_grid.max(axis=0) + edge_m / 2.0
    azimuth_rad, elevation_rad = np.radians(viewpoint.azimuth_deg), np.radians(viewpoint.elevation_deg)
    view = view_of_box(low, high, azimuth_rad, elevation_rad, viewpoint.width)

    def colours(z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(HEIGHTS(heights(z_m + shift[2]))[:, :3], np.float64)

    subject = Subject(cast_at_cubes(on_grid, edge_m), colours, voxel_m=edge_m)
    image = render(subject, view, SUN_WORLD)
    total = view.height + FOOT_PIXELS
    figure = new_figure(view.width / PIXELS_PER_INCH, total / PIXELS_PER_INCH)
    axes = figure.add_axes((0.0, FOOT_PIXELS / total, 1.0, view.height / total))
    axes.set_axis_off()
    axes.imshow(image, interpolation="none")
    size = high - low
    note = "" if edge_m == occupancy.resolution_m else f", drawn in cubes of {edge_m:g} m"
    axes.set_title(
        f"{title}: {size[0]:.4g} x {size[1]:.4g} x {size[2]:.4g} m, voxels of {occupancy.resolution_m:g} m{note}",
        loc="left", fontsize=11, fontweight="bold", color=INK,
    )  # fmt: skip
    place = figure.add_axes((0.3, (FOOT_PIXELS - 50) / total, 0.4, 18 / total))
    bar = figure.colorbar(ScalarMappable(norm=heights, cmap=HEIGHTS), cax=place, orientation="horizontal")
    bar.set_label("height of the surface, z [m]", fontsize=9.5, color=INK)
    bar.outline.set_linewidth(0.0)
    place.tick_params(labelsize=9, colors=INK)
    save_figure(figure, path)
