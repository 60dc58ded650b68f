"""Figures of comparisons: bed surveyed by several missions, and differences between two runs, over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from uwsim.figures.style import add_legend, label_axes, new_figure, save_figure

Curve = tuple[Sequence[float], Sequence[float]]


def draw_comparison(path: Path, curves: Mapping[str, Sequence[Curve]]) -> None:
    """Draw one line per flight, surveyed area [m2] over time [s]; flights of the same mission share a colour.

    curves: keyed by mission, with one curve per flight. Raises OSError.
    """
    figure = new_figure(9.6, 4.4)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, "Area surveyed by sonar", "simulated time [s]", "columns of 1 m with an echo [m²]")
    for k, (name, lines) in enumerate(curves.items()):
        for seed, (times_s, areas_m2) in enumerate(lines):
            label = name if seed == 0 else None
            axes.plot([0.0, *times_s], [0.0, *areas_m2], color=f"C{k}", linewidth=1.3, alpha=0.8, label=label)
            if len(times_s):
                axes.plot(times_s[-1], areas_m2[-1], "o", color=f"C{k}", markersize=4)
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    add_legend(axes, 3)
    save_figure(figure, path)


CURVES_MAX = 8


def draw_divergence(path: Path, gaps: Mapping[str, Sequence[tuple[float, float]]], title: str) -> None:
    """Draw each message's largest absolute difference in any value, in the unit of that value, over simulated time.

    gaps: (time [s], difference above 0) by channel, in drawing order; only the first CURVES_MAX channels are drawn.
    Raises OSError.
    """
    figure = new_figure(9.6, 4.4)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, title, "simulated time [s]", "largest difference of a number in the message, its unit")
    axes.set_yscale("log")
    for name, points in list(gaps.items())[:CURVES_MAX]:
        times_s, values = np.array(points, np.float64).reshape(-1, 2).T
        axes.plot(times_s, values, linewidth=1.2, marker="." if len(points) < 40 else None, label=f"/{name}")
    add_legend(axes, 2)
    save_figure(figure, path)
