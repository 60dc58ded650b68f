"""Plots of imaging sonars' results, for notebooks and `plot()`; up is ahead, and port is on the left."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from uwsim.base.plain_figure import PlainFigure

SIZE_IN = (6.0, 4.5)
COLOURS = "inferno"


def picture(
    level_db: NDArray[np.float32],
    extent: tuple[float, float, float, float],
    limits_db: tuple[float, float],
    title: str,
    across: str,
    up: str,
    is_square: bool = True,
) -> Figure:
    """Return a figure of levels (rows, columns) within an extent: left, right, bottom, top."""
    figure = PlainFigure(SIZE_IN, layout="constrained")
    axes: Axes = figure.add_subplot()
    low, high = limits_db
    shown = axes.imshow(level_db, extent=extent, vmin=low, vmax=high, cmap=COLOURS, interpolation="nearest")
    axes.set(xlabel=across, ylabel=up, title=title, aspect="equal" if is_square else "auto")
    axes.title.set_fontsize(9)
    figure.colorbar(shown, label="level [dB re 1 uPa]")
    return figure


def png(figure: Figure) -> bytes:
    """Return a figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=100)
    return file.getvalue()
