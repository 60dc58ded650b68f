"""Figure of the rays between two points, next to the sound-speed profile."""

from __future__ import annotations

import io
import math
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize

from uwsim.base.atomic_file import write_atomically
from uwsim.figures.style import ACCENT, FAINT_INK, INK, add_colour_bar, label_axes, new_figure, save_figure
from uwsim.instruments.acoustics.rays_between import RaysBetween, ray_path

LEVELS = matplotlib.colormaps["viridis"]


def draw_rays(found: RaysBetween, path: Path) -> None:
    """Draw the rays as a PNG or an SVG, depending on the file suffix. Raises OSError, ValueError."""
    if path.suffix.lower() not in (".png", ".svg"):
        raise ValueError(f"{path}: must end in .png or .svg")
    figure = new_figure(11.0, 5.2)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1, 4))
    source_m, receiver_m, level_db = -found.source_m[2], -found.receiver_m[2], found.arrivals.level_db
    shading = Normalize(level_db.min(), level_db.max()) if len(level_db) else Normalize(-1.0, 0.0)
    lines = [
        ray_path(found.profile, found.bottom_depth_m, source_m, launch_rad, found.range_m)
        for launch_rad in found.arrivals.launch_rad
    ]
    order = np.argsort(level_db)  # the strongest on top
    right.add_collection(
        LineCollection([lines[k] for k in order], colors=LEVELS(shading(level_db[order])), linewidths=0.9)
    )
    right.fill_between(found.bed_m[:, 0], found.bed_m[:, 1], 1e5, color="#d9cbb8", linewidth=0.0)
    deepest_m = max([source_m, receiver_m, *(line[:, 1].max() for line in lines)])
    if math.isfinite(found.bottom_depth_m):
        right.axhline(found.bottom_depth_m, color=FAINT_INK, linewidth=0.8, linestyle=":")
        deepest_m = max(found.bottom_depth_m, float(np.nanmax(found.bed_m[:, 1])))
    right.plot([0.0, found.range_m], [source_m, receiver_m], "o", color=ACCENT, markersize=5)
    left.plot(found.profile[:, 1], found.profile[:, 0], color=INK, linewidth=1.2)
    label_axes(left, "Speed of sound", "[m/s]", "depth [m]")
    label_axes(right, f"{len(lines)} arrivals in {found.scenario}, {found.frequency_hz / 1e3:g} kHz", "range [m]", "")
    left.set_ylim(1.05 * deepest_m, 0.0)
    right.set_xlim(0.0, found.range_m)
    add_colour_bar(figure, right, shading, LEVELS, "level [dB re 1 m]")
    figure.tight_layout()
    if path.suffix.lower() == ".svg":
        with matplotlib.rc_context({"svg.hashsalt": "uwsim", "svg.fonttype": "none"}):
            buffer = io.BytesIO()
            figure.savefig(buffer, format="svg", metadata={"Date": None})
        write_atomically(path, buffer.getvalue())
    else:
        save_figure(figure, path)
