"""Figures of maps in a plane: a slice, two maps from above, and where a map departs from the truth."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, to_rgb
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from uwsim.figures.style import FAINT_INK, INK, add_colour_bar, add_legend, label_axes, new_figure, save_figure
from uwsim.mapping.changes import MapDifference
from uwsim.mapping.info import MapSlice
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.s44 import CONFIDENCE, ORDERS
from uwsim.scoring.seabed_comparison import SeabedComparison

WIDTH_IN = 9.6
COLOURS = {1: "#1b2733", 0: "#9fd0e8", -1: "#f3efe6"}  # dark, mid and light: also distinct in greyscale
NAMES = {1: "occupied", 0: "free", -1: "unknown"}
LABELS = {"x": "east [m]", "y": "north [m]", "z": "z [m], 0 is the water's surface"}


def draw_map_slice(path: Path, cut: MapSlice) -> None:
    """Draw a slice to scale, or stretched if it would otherwise be too slender. Raises OSError."""
    west, east, south, north = cut.extent_m
    ratio = (north - south) / (east - west)
    shown = float(np.clip(ratio, 0.22, 1.6))
    figure = new_figure(WIDTH_IN, WIDTH_IN * shown)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    kind = "Level cut" if cut.axis == "z" else "Upright cut"
    stretch = shown / ratio
    note = f", {cut.up} stretched {stretch:.2g} times" if stretch > 1.01 else ""
    label_axes(
        axes, f"{kind} through the map at {cut.axis} = {cut.at_m:.2f} m{note}", LABELS[cut.across], LABELS[cut.up]
    )
    colours = np.array([to_rgb(COLOURS[state]) for state in (-1, 0, 1)])
    image = colours[cut.states.astype(np.int64) + 1]
    axes.imshow(image, origin="lower", extent=cut.extent_m, interpolation="nearest", aspect="auto", zorder=0)
    counts = {state: int(np.count_nonzero(cut.states == state)) for state in NAMES}
    for state, name in NAMES.items():
        style: dict[str, Any] = {"s": 48, "marker": "s", "edgecolors": "#7d8a96", "linewidths": 0.5}
        axes.scatter([], [], color=COLOURS[state], label=f"{name}: {counts[state]:,} voxels", **style)
    add_legend(axes, 3)
    save_figure(figure, path)


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


CURVE_HEIGHT_IN, GAP_IN = 3.0, 1.7
ERRORS = matplotlib.colormaps["PuOr_r"]  # distinguishable with red-green colour blindness
OBSTACLE, UNJUDGED = "#8f98a1", "#f1f4f6"
MISSED_EDGE, FALSE_EDGE = "#c51b7d", "#00798c"
LIMIT_VOXELS = 2.0  # colour range, wide enough that half-voxel rounding stays pale and larger errors stand out


def draw_map_errors(path: Path, score: MapScore, area_world_m: NDArray[np.float64]) -> None:
    """Draw each cell's error in seabed depth in the polygon (k, 2), and the share of cells below each absolute error.

    Raises OSError if the file cannot be written.
    """
    low, high = area_world_m.min(axis=0), area_world_m.max(axis=0)
    margin = max(0.04 * float((high - low).max()), 1e-3)
    low, high = low - margin, high + margin
    size = high - low
    map_height_in = WIDTH_IN * float(np.clip(size[1] / size[0], 0.2, 2.0))
    total_in = map_height_in + GAP_IN + CURVE_HEIGHT_IN
    figure = new_figure(WIDTH_IN, total_in)

    axes = figure.add_axes((0.0, 1.0 - map_height_in / total_in, 1.0, map_height_in / total_in))
    label_axes(axes, "Errors of the map", "east [m]", "north [m]")
    axes.set_facecolor(UNJUDGED)
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    if score.seabed is not None and score.seabed.judged.any():
        limit_m = LIMIT_VOXELS * score.resolution_m
        limits = Normalize(-limit_m, limit_m, clip=True)
        _draw_errors(axes, score.seabed, limits)
        name = f"depth in the map less true depth [m]; rounding to voxels: {score.resolution_m / 2.0:g} m"
        add_colour_bar(figure, axes, limits, ERRORS, name)
    else:
        east_m, north_m = (low + size / 2.0).tolist()
        axes.text(east_m, north_m, "no seabed to evaluate", ha="center", va="center", fontsize=14, color=FAINT_INK)
    axes.add_patch(Polygon(area_world_m, closed=True, fill=False, edgecolor=INK, linewidth=1.0, linestyle=(0, (5, 3))))
    _draw_voxels(axes, score)
    add_legend(axes, 3)

    curve = figure.add_axes((0.0, 0.0, 1.0, CURVE_HEIGHT_IN / total_in))
    _draw_curve(curve, score.seabed)
    save_figure(figure, path)


def _draw_errors(axes: Axes, seabed: SeabedComparison, limits: Normalize) -> None:
    colours = ERRORS(limits(np.nan_to_num(seabed.error_m)))
    colours[~seabed.judged] = matplotlib.colors.to_rgba(UNJUDGED)
    colours[seabed.obstructed] = matplotlib.colors.to_rgba(OBSTACLE)
    axes.imshow(colours, origin="lower", extent=seabed.grid.extent_m, interpolation="nearest", zorder=0)
    axes.set_autoscale_on(False)


def _draw_voxels(axes: Axes, score: MapScore) -> None:
    style: dict[str, Any] = {"linewidths": 0.8, "facecolors": "none", "zorder": 4}
    missed, false = score.missed_centres_m, score.false_centres_m
    axes.scatter(
        missed[:, 0], missed[:, 1], s=14, marker="o", edgecolors=MISSED_EDGE,
        label=f"visible voxels that the map lacks: {len(missed):,}", **style,
    )  # fmt: skip
    axes.scatter(
        false[:, 0], false[:, 1], s=14, marker="s", edgecolors=FALSE_EDGE,
        label=f"voxels without true surface: {len(false):,}", **style,
    )  # fmt: skip
    count = int(score.seabed.obstructed.sum()) if score.seabed is not None else 0
    axes.scatter(
        [], [], s=40, marker="s", color=OBSTACLE, linewidths=0, label=f"cells under an obstacle, not judged: {count:,}"
    )


def _draw_curve(axes: Axes, seabed: SeabedComparison | None) -> None:
    """Draw the share of cells within each absolute error, and the errors that IHO S-44 allows at the median depth."""
    label_axes(
        axes, "Distribution of the seabed's errors", "absolute error of a cell's depth [m]", "share of the cells [%]"
    )
    axes.set_ylim(0.0, 103.0)
    if seabed is None or not seabed.judged.any():
        axes.set_xlim(0.0, 1.0)
        return
    errors = np.sort(np.abs(seabed.errors_m))
    share = 100.0 * np.arange(1, len(errors) + 1) / len(errors)
    depth_m = float(np.median(seabed.depths_m))
    allowed = {order.tvu_m(np.array([depth_m]))[0]: order.name for order in reversed(ORDERS)}
    shown_m = max(1.15 * float(errors[-1]), 1.35 * min(allowed))
    axes.set_xlim(0.0, shown_m)
    axes.plot(errors, share, color=INK, linewidth=1.8, zorder=3)
    axes.axhline(100.0 * CONFIDENCE, color=FAINT_INK, linewidth=0.8, linestyle=(0, (2, 2)))
    axes.text(0.0, 100.0 * CONFIDENCE - 2.0, f" {100.0 * CONFIDENCE:g} %", fontsize=9, color=FAINT_INK, va="top")
    names = {tvu: "1a, 1b" if name == "1a" else name for tvu, name in allowed.items()}
    for tvu_m, name in names.items():
        if tvu_m <= shown_m:
            axes.axvline(tvu_m, color=FALSE_EDGE, linewidth=1.2)
            axes.text(tvu_m, 50.0, f"{name} ", fontsize=9, color=FALSE_EDGE, rotation=90, ha="right", va="center")
    beyond = ", ".join(f"{name} at {tvu:.2f} m" for tvu, name in sorted(names.items()) if tvu > shown_m)
    note = f"lines: error that IHO S-44 allows at the median depth, {depth_m:.1f} m" + (f"; {beyond}" if beyond else "")
    axes.set_title(note, loc="right", fontsize=8.5, color=INK)
