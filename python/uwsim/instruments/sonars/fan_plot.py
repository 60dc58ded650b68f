"""Plots the fan of a ping, for notebooks and `ping.plot()`."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.figure import Figure

from uwsim import _core

SIZE_IN = (6.0, 4.0)


def plot(ping: _core.Ping) -> Figure:
    """Return a figure of the echoes in the sonar's plane, coloured by intensity, with ahead up and port on the left."""
    figure = Figure(SIZE_IN, layout="constrained")
    axes = figure.add_subplot()
    heard = np.asarray(ping.valid)
    port_m = ping.ranges_m[heard] * np.sin(ping.angles_rad[heard])
    ahead_m = ping.ranges_m[heard] * np.cos(ping.angles_rad[heard])
    reach_m = float(ping.ranges_m[heard].max()) if heard.any() else 1.0
    for angle in (float(ping.angles_rad.min()), float(ping.angles_rad.max())):
        edge = reach_m * np.array([np.sin(angle), np.cos(angle)])
        axes.plot([0.0, -edge[0]], [0.0, edge[1]], color="0.8", linewidth=0.8)
    echoes = axes.scatter(-port_m, ahead_m, c=ping.intensity_db[heard], s=8, cmap="viridis")
    if heard.any():
        figure.colorbar(echoes, label="intensity [dB]")
    axes.plot(0.0, 0.0, "k^", markersize=8)
    axes.set(aspect="equal", xlabel="to starboard [m]", ylabel="along the sonar's axis [m]", title=repr(ping))
    axes.title.set_fontsize(9)
    axes.grid(color="0.92")
    return figure


def png(ping: _core.Ping) -> bytes:
    """Return the figure of `plot` as a PNG file."""
    file = io.BytesIO()
    plot(ping).savefig(file, format="png", dpi=100)
    return file.getvalue()
