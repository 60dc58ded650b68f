"""Figure of the occupied voxels of two maps from above, coloured by which of the maps contain them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.figures.style import FAINT_INK, add_legend, label_axes, new_figure, save_figure
from uwsim.mapping.changes import MapDifference

WIDTH_IN = 9.6
BOTH, ONLY_FIRST, ONLY_SECOND = "#c9d1d8", "#d55e00", "#0072b2"  # vermilion and blue from the Okabe-Ito palette


def draw_map_difference(path: Path, found: MapDifference, names: tuple[str, str]) -> None:
    """Draw the columns that have an occupied voxel in only one of the maps, or in both. names: the map names.

    Raises ValueError if neither map has an occupied voxel, OSError if the file cannot be written.
    """
    everything = np.concatenate([found.only_first_m, found.only_second_m, found.both_m])
    if not len(everything):
        raise ValueError("neither map has an occupied voxel: there is nothing to draw")
    low = everything[:, :2].min(axis=0) - found.resolution_m
    high = everything[:, :2].max(axis=0) + found.resolution_m
    size = high - low
    figure = new_figure(WIDTH_IN, WIDTH_IN * float(np.clip(size[1] / size[0], 0.25, 2.0)))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, f"{found.differing:,} voxels differ in state", "east [m]", "north [m]")
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    layers = (
        (found.both_m, BOTH, "occupied in both"),
        (found.only_first_m, ONLY_FIRST, f"only in {names[0]}"),
        (found.only_second_m, ONLY_SECOND, f"only in {names[1]}"),
    )
    for order, (centres, colour, name) in enumerate(layers):
        _draw_columns(axes, centres, found.resolution_m, colour, order)
        style: dict[str, Any] = {"s": 40, "marker": "s", "linewidths": 0}
        axes.scatter([], [], color=colour, label=f"{name}: {len(centres):,} voxels", **style)
    if not len(found.only_first_m) and not len(found.only_second_m):
        axes.text(0.5, 0.02, "the same voxels are occupied", transform=axes.transAxes, ha="center", color=FAINT_INK)
    add_legend(axes, 3)
    save_figure(figure, path)


def _draw_columns(axes: Any, centres_m: NDArray[np.float64], resolution_m: float, colour: str, order: int) -> None:
    """Fill the squares of the voxel columns."""
    if not len(centres_m):
        return
    corner = centres_m[:, :2].min(axis=0) - resolution_m / 2.0
    at = np.round((centres_m[:, :2] - corner) / resolution_m - 0.5).astype(np.int64)
    columns, rows = at.max(axis=0) + 1
    mask = np.zeros((rows, columns, 4), np.float32)
    rgb = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    mask[at[:, 1], at[:, 0]] = [*rgb, 1.0]
    extent = (corner[0], corner[0] + columns * resolution_m, corner[1], corner[1] + rows * resolution_m)
    axes.imshow(mask, origin="lower", extent=extent, interpolation="nearest", zorder=order)
    axes.set_autoscale_on(False)
