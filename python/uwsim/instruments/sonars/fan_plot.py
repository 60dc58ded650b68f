"""Plots the fan of a ping, or its water column, for notebooks and `ping.plot()`."""

from __future__ import annotations

import io
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uwsim import _core
from uwsim.base.plain_figure import PlainFigure
from uwsim.instruments.sonars.imaging.pixels import polar_pixels

SIZE_IN = (6.0, 4.0)
PIXELS = 700  # height of the picture of a water column
NEAREST_SHARE = 0.1  # share of the range below which levels do not count as noise
SPAN_DB = 40.0  # from the noise to the brightest colour


def plot(ping: _core.Ping) -> Figure:
    """Return a figure of the echoes in the sonar's plane, coloured by intensity; up is ahead, and port is on the left.

    For a ping with a water column, the figure shows the water column instead, with the detections as dots.
    """
    figure = PlainFigure(SIZE_IN, layout="constrained")
    axes = figure.add_subplot()
    heard = np.asarray(ping.valid)
    port_m = ping.ranges_m[heard] * np.sin(ping.angles_rad[heard])
    ahead_m = ping.ranges_m[heard] * np.cos(ping.angles_rad[heard])
    if getattr(ping, "water_column", None) is not None:
        draw_water_column(axes, cast(_core.PhysicsPing, ping))
        axes.plot(-port_m, ahead_m, ".", color="#4cc9f0", markersize=1)
    else:
        reach_m = float(ping.ranges_m[heard].max()) if heard.any() else 1.0
        for angle in (float(ping.angles_rad.min()), float(ping.angles_rad.max())):
            edge = reach_m * np.array([np.sin(angle), np.cos(angle)])
            axes.plot([0.0, -edge[0]], [0.0, edge[1]], color="0.8", linewidth=0.8)
        echoes = axes.scatter(-port_m, ahead_m, c=ping.intensity_db[heard], s=8, cmap="viridis")
        if heard.any():
            figure.colorbar(echoes, label="intensity [dB]")
        axes.grid(color="0.92")
    axes.plot(0.0, 0.0, "k^", markersize=8)
    axes.set(aspect="equal", xlabel="to starboard [m]", ylabel="along the sonar's axis [m]", title=repr(ping))
    axes.title.set_fontsize(9)
    return figure


def draw_water_column(axes: Axes, ping: _core.PhysicsPing) -> float:
    """Draw a ping's water column in the sonar's plane, from the noise level up; up is ahead, and port is on the left.

    Return the drawing's ratio of height to width. Raises ValueError for a ping without a water column.
    """
    if ping.water_column is None:
        raise ValueError("ping.water_column is None: ask for it by sonar.ping(water_column=True)")
    level_db, ranges_m = np.asarray(ping.water_column).T, np.asarray(ping.water_column_ranges_m)
    reach_m = float(ranges_m[-1] + ranges_m[0])
    fan = polar_pixels(level_db, reach_m, float(ping.angles_rad[-1] - ping.angles_rad[0]), PIXELS)
    noise_db = float(np.median(level_db[ranges_m > NEAREST_SHARE * reach_m]))
    image = axes.imshow(
        np.ma.masked_invalid(fan.level_db), extent=fan.extent_m, cmap="inferno", vmin=noise_db,
        vmax=noise_db + SPAN_DB, aspect="equal", interpolation="antialiased",
    )  # fmt: skip
    axes.set_facecolor("0.85")
    assert axes.figure is not None
    axes.figure.colorbar(image, ax=axes, label="level re source level [dB]", fraction=0.04, pad=0.02)
    left, right, bottom, top = fan.extent_m
    return (top - bottom) / (right - left)


def png(ping: _core.Ping) -> bytes:
    """Return the figure of `plot` as a PNG file."""
    file = io.BytesIO()
    plot(ping).savefig(file, format="png", dpi=100)
    return file.getvalue()
