"""A figure of the triangles of a hull that are under water, coloured by the water's pressure on each."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize

from uwsim.base.arrays import Floats
from uwsim.figures.style import ACCENT, INK, add_colour_bar, label_axes, new_figure, save_figure
from uwsim.simulator.forces import WetTriangles

DRY, PRESSURES = "#e8ecef", matplotlib.colormaps["YlGnBu"]
VIEWS = (  # title, axis towards the viewer and its sign, axes across and up
    ("From starboard", (1, -1.0), (0, 2), "ahead, x [m]", "up, z [m]"),
    ("From below", (2, -1.0), (0, 1), "ahead, x [m]", "to port, y [m]"),
    ("From ahead", (0, 1.0), (1, 2), "to port, y [m]", "up, z [m]"),
)


def draw_wet_triangles(path: Path, name: str, hull_m: Floats, wet: WetTriangles, water_z_m: float) -> None:
    """Draw three views of an upright hull as a PNG.

    hull_m: all triangles (n, 3, 3), body frame. water_z_m: of the water's surface, in that frame. Raises OSError.
    """
    pressures_kpa = 1e-3 * np.linalg.norm(wet.forces_body_n, axis=1) / wet.areas_m2
    limits = Normalize(0.0, max(float(pressures_kpa.max(initial=0.0)), 1e-3))
    figure = new_figure(11.0, 8.0)
    grid = figure.add_gridspec(2, 2, hspace=0.3, wspace=0.22)
    for place, (title, (axis, sign), pair, across, up) in zip((grid[0, 0], grid[1, 0], grid[0, 1]), VIEWS, strict=True):
        axes = figure.add_subplot(place)
        for triangles, colours in ((hull_m, DRY), (wet.corners_body_m, PRESSURES(limits(pressures_kpa)))):
            seen = np.flatnonzero(sign * _normals(triangles)[:, axis] > 0)
            order = seen[np.argsort(sign * triangles[seen, :, axis].mean(axis=1), kind="stable")]
            faces = colours if isinstance(colours, str) else colours[order]
            axes.add_collection(
                PolyCollection(list(triangles[order][:, :, pair]), facecolors=faces, edgecolors=INK, linewidths=0.15)
            )
        if 2 in pair and np.isfinite(water_z_m):
            axes.axhline(water_z_m, color=ACCENT, linewidth=1.0)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.05)
        axes.autoscale_view()
        label_axes(axes, title, across, up)
    add_colour_bar(figure, axes, limits, PRESSURES, "pressure on wet triangles [kPa]", left=1.05)
    push_n = float(np.linalg.norm(wet.forces_body_n.sum(axis=0)))
    figure.text(
        0.56, 0.3,
        f"{name}\n{len(wet):,} wet triangles, {wet.area_m2:.3g} m² of {_area_m2(hull_m):.3g} m²\n"
        f"together they push up with {push_n:.4g} N\nthe line is the water's surface",
        fontsize=11, color=INK, linespacing=1.6,
    )  # fmt: skip
    save_figure(figure, path)


def _normals(triangles: Floats) -> Floats:
    a, b, c = triangles.transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def _area_m2(triangles: Floats) -> float:
    return float(0.5 * np.linalg.norm(_normals(triangles), axis=1).sum())
