"""Figure of the map from above: heights, survey area, path and missed voxels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import LightSource, Normalize
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter

from uwsim.figures.style import (
    ACCENT,
    FAINT_INK,
    HEIGHTS,
    INK,
    MISSED,
    PROGRESS,
    add_colour_bar,
    add_legend,
    height_range,
    label_axes,
    new_figure,
    save_figure,
)
from uwsim.mapping.voxel_keys import voxel_keys
from uwsim.scoring.map_score import MapScore

WIDTH_IN = 9.6
MIN_MARGIN_M = 1.0e-3
MAX_LEGS = 1000


def draw_map_from_above(
    path: Path,
    area_world_m: NDArray[np.float64],
    path_world_m: NDArray[np.float64],
    score: MapScore,
    occupied_centres_m: NDArray[np.floating],
    area_name: str = "area to survey",
) -> None:
    """Draw the highest occupied voxel in each column, the polygon (k, 2), the ping path (n, 3), and missed voxels.

    Raises OSError if the file cannot be written.
    """
    frame = np.concatenate([area_world_m, path_world_m[:, :2]])
    low, high = frame.min(axis=0), frame.max(axis=0)
    margin = max(0.06 * float((high - low).max()), MIN_MARGIN_M)
    low, high = low - margin, high + margin
    shown = occupied_centres_m[np.all((occupied_centres_m[:, :2] > low) & (occupied_centres_m[:, :2] < high), axis=1)]
    heights = height_range(shown[:, 2])

    figure = new_figure(WIDTH_IN, WIDTH_IN * float((high - low)[1] / (high - low)[0]))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, "The map from above", "east [m]", "north [m]")
    axes.set_facecolor("#f1f4f6")
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    _draw_heights(axes, shown, score.resolution_m, heights)
    outline: dict[str, Any] = {
        "closed": True,
        "fill": False,
        "edgecolor": INK,
        "linewidth": 1.2,
        "linestyle": (0, (5, 3)),
    }
    axes.add_patch(Polygon(area_world_m, label=area_name, **outline))
    missed = score.missed_centres_m
    if len(missed):
        style: dict[str, Any] = {"s": 3.0, "color": MISSED, "alpha": 0.55, "linewidths": 0, "rasterized": True}
        axes.scatter(missed[:, 0], missed[:, 1], label=f"visible but missed ({len(missed):,} voxels)", **style)
    if len(path_world_m):
        _draw_path(axes, path_world_m)
    _draw_scale(axes, low, high)
    if not len(occupied_centres_m):
        middle = (low + high) / 2.0
        axes.text(middle[0], middle[1], "the map is empty", ha="center", va="center", fontsize=14, color=FAINT_INK)

    if len(shown):
        add_colour_bar(figure, axes, heights, HEIGHTS, "height of the highest occupied voxel, z [m]")
    if len(path_world_m) > 1:
        pings = Normalize(1, len(path_world_m))
        add_colour_bar(figure, axes, pings, PROGRESS, "along the path: ping number", 1.105)
    for handle in add_legend(axes, 4).legend_handles:
        if isinstance(handle, PathCollection) and handle.get_alpha() is not None:
            handle.set_alpha(1.0)
            handle.set_sizes([36.0])
    save_figure(figure, path)


def top_heights(
    centres_m: NDArray[np.floating], resolution_m: float
) -> tuple[NDArray[np.float64], tuple[float, float, float, float]]:
    """Return the highest centre in each voxel column, and the grid's west, east, south and north borders.

    centres_m: (n, 3), n > 0. Rows run from south to north, columns from west to east; empty columns are nan.
    """
    keys = voxel_keys(centres_m, resolution_m)
    first, last = keys.min(axis=0), keys.max(axis=0)
    columns, rows = (last - first + 1)[:2]
    flat = np.full(rows * columns, -np.inf)
    at = (keys[:, 1] - first[1]) * columns + keys[:, 0] - first[0]
    np.maximum.at(flat, at, np.asarray(centres_m[:, 2], np.float64))
    flat[np.isinf(flat)] = np.nan
    west, south = first[:2] * resolution_m
    return flat.reshape(rows, columns), (west, west + columns * resolution_m, south, south + rows * resolution_m)


def _draw_heights(axes: Axes, centres_m: NDArray[np.floating], resolution_m: float, heights: Normalize) -> None:
    if not len(centres_m):
        return
    tops, extent = top_heights(centres_m, resolution_m)
    unknown = np.isnan(tops)
    nearest = distance_transform_edt(unknown, return_distances=False, return_indices=True)
    smooth = np.pad(gaussian_filter(tops[tuple(nearest)], 1.0), 1, mode="edge")  # slopes need a neighbour on each side
    colours = HEIGHTS(heights(tops[tuple(nearest)]))
    light = LightSource(azdeg=315, altdeg=50).hillshade(smooth, vert_exag=1.5, dx=resolution_m, dy=resolution_m)[
        1:-1, 1:-1
    ]
    colours[..., :3] *= (0.55 + 0.6 * light)[..., None]
    colours[..., 3] = ~unknown
    axes.imshow(np.clip(colours, 0.0, 1.0), origin="lower", extent=extent, interpolation="nearest", zorder=0)


def _draw_path(axes: Axes, path_world_m: NDArray[np.float64]) -> None:
    xy = path_world_m[:, :2]
    if len(xy) > 1:
        axes.plot(xy[:, 0], xy[:, 1], color="#20242a", linewidth=2.6, alpha=0.55, solid_joinstyle="round")
        step = 1 + len(xy) // MAX_LEGS  # pings per leg; each leg has one colour
        starts = np.arange(0, len(xy) - 1, step)
        legs = LineCollection(
            [xy[start : start + step + 1] for start in starts], cmap=PROGRESS, linewidths=1.4, capstyle="round"
        )
        legs.set_array(starts)
        axes.add_collection(legs)
    marks: dict[str, Any] = {"s": 75, "edgecolors": INK, "linewidths": 1.2, "zorder": 5}
    axes.scatter(*xy[0], marker="o", color="white", label="first ping", **marks)
    axes.scatter(*xy[-1], marker="s", color=ACCENT, label="last ping", **marks)


def _draw_scale(axes: Axes, low: NDArray[np.float64], high: NDArray[np.float64]) -> None:
    """Draw a scale bar and a north arrow in the lower corners of the margin."""
    size = high - low
    length = 10.0 ** np.floor(np.log10(size[0] / 4.0))
    length *= max(step for step in (1, 2, 5) if step * length <= size[0] / 4.0)
    x, y = high[0] - 0.02 * size[0] - length, low[1] + 0.02 * size[1]
    halo = [withStroke(linewidth=3, foreground="white")]
    axes.plot([x, x + length], [y, y], color=INK, linewidth=3, solid_capstyle="butt", path_effects=halo)
    text: dict[str, Any] = {"fontsize": 9, "color": INK, "path_effects": halo, "va": "center"}
    axes.text(x - 0.008 * size[0], y, f"{length:g} m", ha="right", **text)
    arrow: dict[str, Any] = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.2, "path_effects": halo}
    north = low + size * [0.02, 0.06]
    axes.annotate("", xy=tuple(north), xytext=tuple(low + size * [0.02, 0.01]), arrowprops=arrow)
    axes.text(north[0] + 0.008 * size[0], low[1] + 0.03 * size[1], "N", ha="left", **text)
