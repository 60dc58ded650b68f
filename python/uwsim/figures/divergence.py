"""Figure of the differences between two runs over time, channel by channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from uwsim.figures.style import add_legend, label_axes, new_figure, save_figure

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
