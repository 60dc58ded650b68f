"""Figure of a slice through a map: occupied, free and unknown voxels in a horizontal or vertical plane."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from uwsim.figures.style import add_legend, label_axes, new_figure, save_figure
from uwsim.mapping.slice import MapSlice

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
