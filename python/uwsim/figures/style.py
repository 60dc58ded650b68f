"""The common style of all figures: white background, heights in viridis, vehicles in warm colours."""

from __future__ import annotations

import io
import re
import zlib
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from uwsim.base.atomic_file import write_atomically
from uwsim.base.plain_figure import PlainFigure, show_as_written

PIXELS_PER_INCH = 150
PAD_IN = 0.15
INK, FAINT_INK = "#1b2733", "#7d8a96"
ACCENT, MISSED = "#ff6a3d", "#e3127e"
HEIGHTS = matplotlib.colormaps["viridis"]
PROGRESS = matplotlib.colormaps["YlOrRd"]
OWN_LABEL = re.compile(r"_child\d+|_nolegend_")
"""The labels that matplotlib itself gives to what is not to be in a legend."""


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure that needs no display."""
    figure = PlainFigure(figsize=(width_in, height_in), dpi=PIXELS_PER_INCH, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def label_axes(axes: Axes, title: str, x_label: str, y_label: str) -> None:
    """Set the title, the axis labels and unobtrusive ticks."""
    axes.set_title(title, loc="left", fontsize=11, fontweight="bold", color=INK)
    axes.set_xlabel(x_label, fontsize=9.5, color=INK)
    axes.set_ylabel(y_label, fontsize=9.5, color=INK)
    axes.tick_params(labelsize=9, colors=INK, width=0.6)
    for spine in axes.spines.values():
        spine.set_color(FAINT_INK)
        spine.set_linewidth(0.6)


def add_colour_bar(
    figure: Figure, axes: Axes, limits: Normalize, colours: Colormap, label: str, left: float = 1.015
) -> None:
    """Add a colour bar as tall as the axes. left: its distance from the left edge of the axes, in axes widths."""
    place = axes.inset_axes((left, 0.0, 0.018, 1.0))
    bar = figure.colorbar(ScalarMappable(norm=limits, cmap=colours), cax=place)
    bar.set_label(label, fontsize=9.5, color=INK)
    bar.ax.tick_params(labelsize=9, colors=INK, width=0.6)
    bar.outline.set_linewidth(0.0)


def add_legend(axes: Axes, columns: int) -> Legend:
    """Add a legend below the axes, under the x axis ticks and label."""
    keep_all_labels(axes)
    return axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=4.4, ncols=columns, fontsize=9.5, frameon=False,
        handletextpad=0.5,
    )  # fmt: skip


def keep_all_labels(axes: Axes) -> None:
    """Put a space before labels that begin with "_", such as names from a file, which a legend would leave out."""
    for artist in axes.get_children():
        if (label := str(artist.get_label())).startswith("_") and not OWN_LABEL.fullmatch(label):
            artist.set_label(f" {label}")


def save_figure(figure: Figure, path: Path) -> None:
    """Write a PNG atomically, without date or version, so that equal figures give equal bytes. Raises OSError."""
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib's class has no types
    show_as_written(figure)  # for a pyplot's figure, and before the layout measures the texts
    _fit(figure, canvas)
    canvas.draw()
    buffer = io.BytesIO()
    # No alpha, and run-length compression: half the time of the default, for the same number of bytes.
    opaque = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    opaque.save(buffer, "png", compress_level=1, compress_type=zlib.Z_RLE)
    write_atomically(path, buffer.getvalue())


def _fit(figure: Figure, canvas: Any) -> None:
    """Fit a figure's size to its contents; savefig's bbox_inches="tight" would draw the figure twice."""
    if (layout := figure.get_layout_engine()) is not None:
        layout.execute(figure)
        figure.set_layout_engine("none")
    box = figure.get_tightbbox(canvas.get_renderer()).padded(PAD_IN)
    size = figure.get_size_inches()

    def moved(places: ArrayLike) -> NDArray[np.float64]:
        return np.asarray((np.asarray(places, np.float64) * size - box.min) / box.size)

    for axes in figure.axes:
        axes.set_position(Bbox(moved(axes.get_position(original=True).get_points())))
    for text in figure.texts:
        text.set_position(tuple(moved(text.get_position())))
    figure.set_size_inches(*box.size)


def height_range(heights_m: NDArray[np.floating]) -> Normalize:
    """Return the range of the colour scale: all heights except 0.5 % at each end; [-1, 0] if there are none."""
    if not heights_m.size:
        return Normalize(-1.0, 0.0, clip=True)
    low, high = np.percentile(heights_m, [0.5, 99.5])
    return Normalize(float(low), max(float(high), float(low) + 0.5), clip=True)
