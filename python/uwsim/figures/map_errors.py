"""Figure of a map's errors: seabed depth errors from above, missed and false voxels, and the error distribution."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from uwsim.figures.style import FAINT_INK, INK, add_colour_bar, add_legend, label_axes, new_figure, save_figure
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.s44 import CONFIDENCE, ORDERS
from uwsim.scoring.seabed_comparison import SeabedComparison

WIDTH_IN, CURVE_HEIGHT_IN, GAP_IN = 9.6, 3.0, 1.7
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
