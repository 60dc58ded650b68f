"""A picture of a fleet survey: the merged map from above, and the coverage of each tile."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.campaigns.fleet.tiles import Tile
from uwsim.figures.style import (
    ACCENT,
    HEIGHTS,
    MISSED,
    add_colour_bar,
    height_range,
    label_axes,
    new_figure,
    save_figure,
)
from uwsim.mapping import OccupancyMap

MAX_PIXELS = 1200
FEW = 150
"""The largest number of tiles for which each has room for a label."""


def draw_fleet(
    path: Path, map_path: Path, tiles: list[Tile], results: Mapping[int, Mapping[str, Any]],
    scores: Mapping[int, Mapping[str, Any]], figures: Mapping[str, Any],
) -> None:  # fmt: skip
    """Draw the lowest occupied voxel in each column, and the outline and coverage of each tile. Raises OSError."""
    occupied = OccupancyMap.read(map_path).occupied_voxels()
    figure = new_figure(9.0, 8.0)
    axes = figure.add_subplot()
    if len(occupied):
        low, high = occupied[:, :2].min(axis=0), occupied[:, :2].max(axis=0)
        edge_m = max(float(figures["voxel_m"]), float((high - low).max()) / MAX_PIXELS)
        columns, rows = ((high - low) / edge_m).astype(int) + 1
        heights = np.full((rows, columns), np.inf)
        i, j = ((occupied[:, :2] - low) / edge_m).astype(int).T
        np.minimum.at(heights, (j, i), occupied[:, 2])
        heights[np.isinf(heights)] = np.nan
        limits = height_range(heights[np.isfinite(heights)])
        extent = (low[0], low[0] + columns * edge_m, low[1], low[1] + rows * edge_m)
        axes.imshow(heights, origin="lower", extent=extent, cmap=HEIGHTS, norm=limits, interpolation="nearest")
        add_colour_bar(figure, axes, limits, HEIGHTS, "z [m]")
    for tile in tiles:
        outline = np.array([*tile.area_m, tile.area_m[0]])
        result = results.get(tile.number)  # there is none of a dry tile
        mapped = result is not None and not result["error"]
        axes.plot(*outline.T, color="white" if mapped else MISSED, linewidth=0.8)
        if len(tiles) <= FEW:
            x, y = np.array(tile.area_m).mean(axis=0)
            text = _text(result, scores.get(tile.number))
            axes.text(x, y, text, ha="center", va="center", fontsize=7, color="white" if mapped else ACCENT)
    axes.set_aspect("equal")
    share = figures.get("coverage")
    mapped_text = f", {100 * share:.1f} % of the visible surface mapped" if share else ""
    title = f"{figures['tiles_flown']:,} tiles{mapped_text}"
    label_axes(axes, title, "x, east [m]", "y, north [m]")
    save_figure(figure, path)


def _text(result: Mapping[str, Any] | None, score: Mapping[str, Any] | None) -> str:
    if result is None:
        return "dry"
    if result["error"]:
        return "failed"
    return f"{100 * score['covered'] / score['visible']:.1f} %" if score and score["visible"] else ""
