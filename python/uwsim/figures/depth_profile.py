"""Figure of the sonar's depth and the true seabed below, along the path."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.figures.style import ACCENT, add_legend, label_axes, new_figure, save_figure

GROUND, GROUND_LINE, WATER = "#b9ab98", "#6d6150", "#e6f0f6"


def draw_depth_profile(path: Path, world: _core.World, path_world_m: NDArray[np.float64]) -> None:
    """Draw the height z of the sonar and of the terrain below it against the distance flown.

    path_world_m: (n, 3), the sonar's position at each ping, n >= 2. Raises ValueError for fewer positions, OSError if
    the file cannot be written.
    """
    if len(path_world_m) < 2:
        raise ValueError(f"path_world_m = {len(path_world_m)} positions: must be two or more")
    flown_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path_world_m, axis=0), axis=1))])
    sonar_m = path_world_m[:, 2]
    ground_m = world.height_at(np.ascontiguousarray(path_world_m[:, :2]))
    low = float(np.nanmin(np.append(ground_m, sonar_m)))
    figure = new_figure(9.6, 3.0)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, "Depth along the path", "distance flown [m]", "z [m], 0 is the water's surface")
    axes.set_facecolor(WATER)
    axes.set_xlim(0.0, max(float(flown_m[-1]), 1.0))
    axes.set_ylim(low - 0.08 * abs(low) - 0.5, 0.0)
    axes.fill_between(flown_m, ground_m, axes.get_ylim()[0], color=GROUND, linewidth=0, label="true seabed below")
    axes.plot(flown_m, ground_m, color=GROUND_LINE, linewidth=0.8)
    axes.plot(flown_m, sonar_m, color=ACCENT, linewidth=1.4, label="sonar")
    add_legend(axes, 2)
    save_figure(figure, path)
