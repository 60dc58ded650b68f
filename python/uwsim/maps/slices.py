"""A cut through a map: what is occupied, free and unknown on a level or upright plane."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from uwsim.figure_style import add_legend, dress, new_figure, save_figure
from uwsim.mapping import OccupancyMap
from uwsim.maps.files import bounds_of

Axis = Literal["x", "y", "z"]
MAX_CELLS = 64_000_000
WIDTH_IN = 9.6
COLOURS = {1: "#1b2733", 0: "#9fd0e8", -1: "#f3efe6"}  # dark, mid and light: told apart in grey too
NAMES = {1: "occupied", 0: "free", -1: "unknown"}
LABELS = {"x": "east [m]", "y": "north [m]", "z": "z [m], 0 is the water's surface"}


@dataclass(frozen=True, eq=False)
class Slice:
    """States (rows, columns) int8 on a plane, 1 occupied, 0 free, -1 unknown; rows along `up` from low to high.

    axis: the plane's normal. at_m: the middle of the layer of voxels cut. extent_m: along `across` and `up`.
    """

    states: NDArray[np.int8]
    axis: Axis
    at_m: float
    across: Axis
    up: Axis
    extent_m: tuple[float, float, float, float]


def slice_map(occupancy: OccupancyMap, axis: Axis, at_m: float) -> Slice:
    """Cut the layer of voxels that holds the plane, as far as the map knows anything.

    Raises ValueError when the map is empty, at_m lies outside what it knows, or there are more than MAX_CELLS voxels.
    """
    if not np.isfinite(at_m):
        raise ValueError(f"{axis} = {at_m} m: must be finite")
    bounds = bounds_of(occupancy)
    if bounds is None:
        raise ValueError("the map is empty: there is nothing to cut")
    normal = "xyz".index(axis)
    low, high, edge_m = bounds.low_m, bounds.high_m, occupancy.resolution_m
    if not low[normal] <= at_m < high[normal]:
        raise ValueError(f"{axis} = {at_m:g} m: must be in [{low[normal]:g}, {high[normal]:g}) m, which the map knows")
    first, second = (k for k in range(3) if k != normal)
    counts = np.round((high - low) / edge_m).astype(np.int64)
    if counts[first] * counts[second] > MAX_CELLS:
        raise ValueError(f"{counts[first]} x {counts[second]} voxels: must be at most {MAX_CELLS}")
    middle = float(low[normal] + (np.floor((at_m - low[normal]) / edge_m) + 0.5) * edge_m)
    states = np.empty((counts[second], counts[first]), np.int8)
    across = low[first] + (np.arange(counts[first]) + 0.5) * edge_m
    for row in range(counts[second]):
        points = np.empty((len(across), 3))
        points[:, first], points[:, second], points[:, normal] = across, low[second] + (row + 0.5) * edge_m, middle
        states[row] = occupancy.state_at(points)
    axes: tuple[Axis, Axis, Axis] = ("x", "y", "z")
    extent = (float(low[first]), float(high[first]), float(low[second]), float(high[second]))
    return Slice(states, axis, middle, axes[first], axes[second], extent)


def draw_slice(path: Path, cut: Slice) -> None:
    """Draw it to scale, unless it is so slender that it must be stretched to be seen. Raises OSError."""
    west, east, south, north = cut.extent_m
    ratio = (north - south) / (east - west)
    shown = float(np.clip(ratio, 0.22, 1.6))
    figure = new_figure(WIDTH_IN, WIDTH_IN * shown)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    kind = "Level cut" if cut.axis == "z" else "Upright cut"
    stretch = shown / ratio
    note = f", {cut.up} stretched {stretch:.2g} times" if stretch > 1.01 else ""
    dress(axes, f"{kind} through the map at {cut.axis} = {cut.at_m:.2f} m{note}", LABELS[cut.across], LABELS[cut.up])
    colours = np.array([to_rgb(COLOURS[state]) for state in (-1, 0, 1)])
    image = colours[cut.states.astype(np.int64) + 1]
    axes.imshow(image, origin="lower", extent=cut.extent_m, interpolation="nearest", aspect="auto", zorder=0)
    counts = {state: int(np.count_nonzero(cut.states == state)) for state in NAMES}
    for state, name in NAMES.items():
        style: dict[str, Any] = {"s": 48, "marker": "s", "edgecolors": "#7d8a96", "linewidths": 0.5}
        axes.scatter([], [], color=COLOURS[state], label=f"{name}: {counts[state]:,} voxels", **style)
    add_legend(axes, 3)
    save_figure(figure, path)
