"""A plot of a vehicle's path, for notebooks and `track.plot()`."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from uwsim.base.plain_figure import PlainFigure

SIZE_IN = (6.0, 5.0)


def plot(path_world_m: NDArray[np.float64], area_world_m: NDArray[np.float64] | None = None, title: str = "") -> Figure:
    """Return a figure of a path (n, 3) seen from above, coloured by height z, with the area (k, 2) to be covered."""
    figure = PlainFigure(SIZE_IN, layout="constrained")
    axes = figure.add_subplot()
    if area_world_m is not None and len(area_world_m):
        axes.plot(*np.vstack([area_world_m, area_world_m[:1]]).T, "--", color="0.6", linewidth=1.0, label="area")
    if len(path_world_m):
        x, y, z = path_world_m.T
        axes.plot(x, y, color="0.8", linewidth=0.8, zorder=1)
        dots = axes.scatter(x, y, c=z, s=6, cmap="viridis", zorder=2)
        figure.colorbar(dots, label="z [m]")
        axes.plot(x[0], y[0], "o", color="#ff6a3d", label="start", zorder=3)
        axes.plot(x[-1], y[-1], "s", color="#d00070", label="end", zorder=3)
        axes.legend(fontsize=8)
    axes.set(aspect="equal", xlabel="east [m]", ylabel="north [m]", title=title)
    axes.title.set_fontsize(9)
    axes.grid(color="0.92")
    return figure


def png(figure: Figure) -> bytes:
    """Return a figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=100)
    return file.getvalue()
