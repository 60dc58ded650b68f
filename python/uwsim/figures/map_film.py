"""A film of a map that grows beside the truth: both from the same view, with the same light and colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.font_manager import findfont
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from scipy.spatial import ConvexHull

from uwsim import _core
from uwsim.base.atomic_file import write_atomically
from uwsim.base.polygon import inside
from uwsim.figures.clip_prism import ClipPrism
from uwsim.figures.pinhole_view import view_of_box
from uwsim.figures.reel import PictureStore
from uwsim.figures.render_3d import Subject, cast_at_cubes, cast_at_world, render
from uwsim.figures.style import ACCENT, HEIGHTS, INK, height_range
from uwsim.figures.truth_and_map import (
    AZIMUTH_RAD,
    CUT_DEPTH_M,
    OVERVIEW_ELEVATION_RAD,
    SUN_WORLD,
    grid_inside,
    ground_heights,
)

FILMS = (".webp", ".gif")
GAP_PIXELS, HEAD_PIXELS = 16, 44
TEXT_SHARE = 0.033  # of the width, in which the text above the map fits
FARTHEST_M = 12_000.0  # deeper than any sea
LAST_SHARE = 20  # the last picture is shown as long as this many others


class MapFilm:
    """The pictures of a film: the truth on the left, and the map so far on the right. They are kept in a file.

    rays: the ray scene of the world. area_world_m: the polygon (k, 2) that is shown. width: of each half [pixels].
    """

    def __init__(
        self, world: _core.World, rays: _core.RayScene, area_world_m: NDArray[np.float64], voxel_m: float, width: int
    ) -> None:
        self._area = area_world_m[ConvexHull(area_world_m).vertices]
        ground = ground_heights(world, self._area)
        if not len(ground):
            raise ValueError("a film needs terrain in the survey's area")
        self._voxel_m = voxel_m
        self._heights = height_range(_tops(rays, self._area, float(ground.max())))
        floor_m = float(ground.min()) - CUT_DEPTH_M
        low, high = np.append(self._area.min(axis=0), floor_m), np.append(self._area.max(axis=0), ground.max())
        self._view = view_of_box(low, high, AZIMUTH_RAD, OVERVIEW_ELEVATION_RAD, width)
        self._sun = SUN_WORLD / np.linalg.norm(SUN_WORLD)
        block = Subject(cast_at_world(rays), self._colours, ClipPrism(self._area, floor_m), world.height_at)
        self._truth = render(block, self._view, self._sun)
        self._font = ImageFont.truetype(findfont("DejaVu Sans"), TEXT_SHARE * width)
        self.pictures = PictureStore()

    def add(self, occupied_centres_m: NDArray[np.float64], path_world_m: NDArray[np.float64], text: str) -> None:
        """Add a picture of voxels (n, 3) and of the sonar's path so far (m, 3), with a text above the map."""
        wide, high = self._view.width, self._view.height
        picture = Image.new("RGB", (2 * wide + GAP_PIXELS, high + HEAD_PIXELS), "white")
        picture.paste(Image.fromarray(self._truth), (0, HEAD_PIXELS))
        picture.paste(self._map(occupied_centres_m, path_world_m), (wide + GAP_PIXELS, HEAD_PIXELS))
        pen = ImageDraw.Draw(picture)
        for left, line in ((0, "truth"), (wide + GAP_PIXELS, text)):
            pen.text((left + GAP_PIXELS, HEAD_PIXELS / 2), line, fill=INK, font=self._font, anchor="lm")
        self.pictures.add(picture)

    def _map(self, centres_m: NDArray[np.float64], path_world_m: NDArray[np.float64]) -> Image.Image:
        mapped = centres_m[inside(centres_m[:, :2], self._area)]
        if len(mapped):
            cubes = Subject(cast_at_cubes(mapped, self._voxel_m), self._colours, voxel_m=self._voxel_m)
            picture = Image.fromarray(render(cubes, self._view, self._sun))
        else:
            picture = Image.new("RGB", (self._view.width, self._view.height), "white")
        if len(path_world_m) > 1:
            points = [(float(x), float(y)) for x, y in self._view.project(path_world_m)]
            ImageDraw.Draw(picture).line(points, fill=ACCENT, width=2)
        return picture

    def _colours(self, heights_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(HEIGHTS(self._heights(heights_m))[:, :3], np.float64)


def _tops(rays: _core.RayScene, area_m: NDArray[np.float64], ground_m: float) -> NDArray[np.float64]:
    """Return the heights (n,) of ground and solids as seen from above, on a grid of about 200 x 200."""
    sides = grid_inside(area_m)
    above_m = np.column_stack([sides, np.full(len(sides), max(0.0, ground_m + 1.0))])
    down = np.tile([0.0, 0.0, -1.0], (len(sides), 1))
    ranges_m = np.asarray(rays.cast(above_m, down, FARTHEST_M).ranges_m, np.float64)
    return (above_m[:, 2] - ranges_m)[np.isfinite(ranges_m)]


def write_film(path: Path, pictures: PictureStore, seconds: float) -> None:
    """Write an endless film that lasts `seconds`. Raises ValueError for another suffix than FILMS, or OSError."""
    if path.suffix not in FILMS:
        raise ValueError(f"film '{path}': must end in {' or '.join(FILMS)}")
    shown_ms = round(1000 * seconds / (len(pictures) - 1 + LAST_SHARE))
    durations = [shown_ms] * (len(pictures) - 1) + [LAST_SHARE * shown_ms]
    write_atomically(path, pictures.reel().encoded(path.suffix[1:], durations))
