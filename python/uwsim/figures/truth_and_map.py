"""Figure of truth and map side by side in 3D, with the same view, light and colours."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from uwsim import _core
from uwsim.base.polygon import inside
from uwsim.figures.clip_prism import ClipPrism
from uwsim.figures.pinhole_view import PinholeView, view_of_box
from uwsim.figures.render_3d import Subject, cast_at_cubes, cast_at_world, render
from uwsim.figures.style import (
    ACCENT,
    FAINT_INK,
    HEIGHTS,
    INK,
    PIXELS_PER_INCH,
    height_range,
    new_figure,
    save_figure,
)

PANEL_PIXELS, GAP_PIXELS = 960, 50
AZIMUTH_RAD = -2.06
OVERVIEW_ELEVATION_RAD, DETAIL_ELEVATION_RAD = 0.66, 0.42
DETAIL_HALF_M = np.array([15.0, 11.0])
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
CUT_DEPTH_M = 1.5
SUN_WORLD = np.array([-0.62, 0.21, 0.76])


_Row = tuple[PinholeView, NDArray[np.uint8], NDArray[np.uint8] | None]


@dataclass(frozen=True, eq=False)
class _Comparison:
    """The truth, the map, and the height colour scale for both."""

    world: _core.World
    truth: _core.RayScene
    voxel_m: float
    occupied_centres_m: NDArray[np.floating]
    heights: Normalize

    def colours(self, heights_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return colours (n, 3) for heights (n,)."""
        return np.asarray(HEIGHTS(self.heights(heights_m))[:, :3], np.float64)


@dataclass(frozen=True, eq=False)
class TruthAndMap:
    """Rendered pictures of truth and map, ready to be laid out."""

    rows: list[_Row]
    map_name: str
    heights: Normalize


def render_truth_and_map(
    world: _core.World,
    rays: _core.RayScene,
    area_world_m: NDArray[np.float64],
    occupied_centres_m: NDArray[np.floating],
    voxel_m: float,
) -> TruthAndMap:
    """Render the polygon (k, 2) as a block cut from the world, and the map's voxels in the same view.

    A second row shows a close-up of both around the tallest solid in the map, if there is one. rays: the ray scene of
    the same world. May run on a separate thread, in parallel with other figures.
    """
    area = area_world_m[ConvexHull(area_world_m).vertices]
    occupied = occupied_centres_m[inside(occupied_centres_m[:, :2], area)]
    heights = height_range(ground_heights(world, area))
    comparison = _Comparison(world, rays, voxel_m, occupied, heights)

    detail = _detail_block(world, occupied, voxel_m)
    blocks = [(area, OVERVIEW_ELEVATION_RAD)]
    if detail is not None:
        blocks.append((detail, DETAIL_ELEVATION_RAD))
    rows = [_render_block(comparison, block, elevation) for block, elevation in blocks]
    return TruthAndMap(rows, f"map: {len(occupied_centres_m):,} occupied voxels of {voxel_m:g} m", heights)


def draw_truth_and_map(path: Path, rendered: TruthAndMap, path_world_m: NDArray[np.float64]) -> None:
    """Draw the pictures side by side, with the path (n, 3) on top. Raises OSError if the file cannot be written."""
    _compose(path, rendered.rows, rendered.map_name, path_world_m, rendered.heights)


def _compose(
    path: Path, rows: list[_Row], map_name: str, path_world_m: NDArray[np.float64], heights: Normalize
) -> None:
    """Lay out the pictures pixel by pixel, two per row, with the path on the first row and a colour bar below."""
    wide = 2 * PANEL_PIXELS + GAP_PIXELS
    high = sum(view.height + GAP_PIXELS for view, _, _ in rows)
    figure = new_figure(wide / PIXELS_PER_INCH, high / PIXELS_PER_INCH)
    top = high
    for row, (view, *pictures) in enumerate(rows):
        top -= view.height + GAP_PIXELS
        for column, image in enumerate(pictures):
            left = column * (PANEL_PIXELS + GAP_PIXELS)
            axes = figure.add_axes((left / wide, top / high, PANEL_PIXELS / wide, view.height / high))
            axes.set_axis_off()
            title = ("truth", map_name)[column] if row == 0 else ("truth", "map")[column] + ", close up"
            axes.set_title(title, loc="left", fontsize=14, fontweight="bold", color=INK)
            if image is None:
                axes.text(0.5, 0.5, "the map is empty here", ha="center", fontsize=16, color=FAINT_INK)
                continue
            axes.imshow(image, interpolation="none")
            if row == 0:
                _draw_path(axes, view, path_world_m)
    place = figure.add_axes((0.3, (top - 50) / high, 0.4, 18 / high))
    bar = figure.colorbar(ScalarMappable(norm=heights, cmap=HEIGHTS), cax=place, orientation="horizontal")
    bar.set_label("height, z [m]", fontsize=13, color=INK)
    bar.outline.set_linewidth(0.0)
    place.tick_params(labelsize=12, colors=INK)
    save_figure(figure, path)


def ground_heights(world: _core.World, area_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the terrain heights at `grid_inside` the polygon; (0,) if there is no terrain."""
    heights = world.height_at(grid_inside(area_m))
    return np.asarray(heights[np.isfinite(heights)], np.float64)


def grid_inside(area_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points (n, 2) of a grid of about 200 x 200 inside the polygon (k, 2)."""
    low, high = area_m.min(axis=0), area_m.max(axis=0)
    x, y = np.meshgrid(np.linspace(low[0], high[0], 200), np.linspace(low[1], high[1], 200))
    grid = np.stack([x.ravel(), y.ravel()], axis=1)
    return grid[inside(grid, area_m)]


def _detail_block(
    world: _core.World, occupied_centres_m: NDArray[np.floating], voxel_m: float
) -> NDArray[np.float64] | None:
    """Return a rectangle (4, 2) around the solid that stands highest above the ground in the map, or None.

    Solids higher than half the rectangle's length are ignored, since the picture could not show the ground around them,
    and so are places where the ground itself rises by more, which would fill the picture with the block's sides.
    """
    above_m = occupied_centres_m[:, 2] - world.height_at(np.asarray(occupied_centres_m[:, :2], np.float64))
    with np.errstate(invalid="ignore"):
        stands = above_m > 2.0 * voxel_m
    standing, above_m = np.asarray(occupied_centres_m[stands], np.float64), above_m[stands]
    best, highest_m = None, 0.0
    for solid, low, high in _solids(world):
        mine = np.all((standing >= low - voxel_m) & (standing <= high + voxel_m), axis=1)
        mine[mine] = solid.distance_m(standing[mine]) <= voxel_m
        if mine.any() and highest_m < above_m[mine].max() < DETAIL_HALF_M[0]:
            xy = standing[mine, :2]
            peak = xy[above_m[mine].argmax()]
            block = xy[np.all(np.abs(xy - peak) < DETAIL_HALF_M, axis=1)].mean(axis=0) + DETAIL_HALF_M * CORNERS
            ground_m = ground_heights(world, block)
            if len(ground_m) == 0 or np.ptp(ground_m) < DETAIL_HALF_M[0]:
                best, highest_m = block, float(above_m[mine].max())
    return best


def _solids(world: _core.World) -> list[tuple[_core.RayScene, NDArray[np.float64], NDArray[np.float64]]]:
    """Return a separate ray scene for each solid in the world, and the low and high corner (3,) of its box."""
    vertices, triangles, labels = world.surface_mesh(with_terrain=False)
    solids = []
    for label in np.unique(labels):
        alone = _core.World()
        used, indices = np.unique(triangles[labels == label], return_inverse=True)
        corners = np.asarray(vertices[used], np.float64)
        alone.add_solid("solid", corners, indices.reshape(-1, 3).astype(np.uint32))
        solids.append((_core.RayScene(alone), corners.min(axis=0), corners.max(axis=0)))
    return solids


def _render_block(comparison: _Comparison, area_m: NDArray[np.float64], elevation_rad: float) -> _Row:
    """Return the view and the pictures of truth and map over a convex polygon; the latter is None for an empty map."""
    mapped = comparison.occupied_centres_m[inside(comparison.occupied_centres_m[:, :2], area_m)]
    ground = ground_heights(comparison.world, area_m)
    levels = np.concatenate([ground, mapped[:, 2]]) if len(ground) + len(mapped) else np.zeros(1)
    floor_m = float(levels.min()) - CUT_DEPTH_M
    # The top is a percentile, so that a few voxels far above all others, such as the station's, do not compress the
    # rest.
    top_m = max(float(np.percentile(levels, 99.7)), float(ground.max(initial=floor_m)))
    low, high = np.append(area_m.min(axis=0), floor_m), np.append(area_m.max(axis=0), top_m)
    view = view_of_box(low, high, AZIMUTH_RAD, elevation_rad, PANEL_PIXELS)

    sun = SUN_WORLD / np.linalg.norm(SUN_WORLD)
    block = Subject(
        cast_at_world(comparison.truth), comparison.colours, ClipPrism(area_m, floor_m), comparison.world.height_at
    )
    truth = render(block, view, sun)
    if not len(mapped):
        return view, truth, None
    cubes = cast_at_cubes(mapped, comparison.voxel_m)
    return view, truth, render(Subject(cubes, comparison.colours, voxel_m=comparison.voxel_m), view, sun)


def _draw_path(axes: Axes, view: PinholeView, path_world_m: NDArray[np.float64]) -> None:
    if len(path_world_m) > 1:
        columns, rows = view.project(path_world_m).T - 0.5
        axes.set_autoscale_on(False)
        axes.plot(columns, rows, color="white", linewidth=2.6, alpha=0.45)
        axes.plot(columns, rows, color=ACCENT, linewidth=1.3)
