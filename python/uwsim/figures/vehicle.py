"""Figures of a vehicle: three views with its thrusters, fins and fields of view; turning circles; eigenvalues."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Polygon
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.figures.style import ACCENT, FAINT_INK, INK, keep_all_labels, label_axes, new_figure, save_figure
from uwsim.scenario.build.equipment import actuators_spec
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.spec.vehicle import VehicleModel

View = tuple[Floats, Floats]
"""Position (3,) and rays (n, 3) of an instrument, body frame."""
HULL, THRUSTER, FIN = "#c9d3dc", ACCENT, "#2a6f97"
REACH = 0.6
"""Length of the drawn fields of view, as a share of the hull's longest side."""
PLANES = (
    ("From above", (0, 1), "ahead, x [m]", "to port, y [m]"),
    ("From starboard", (0, 2), "ahead, x [m]", "up, z [m]"),
    ("From ahead", (1, 2), "to port, y [m]", "up, z [m]"),
)
COLOURS = matplotlib.colormaps["tab20"]


def draw_vehicle(
    path: Path,
    model: VehicleModel,
    centre_of_mass_m: Sequence[float],
    centre_of_buoyancy_m: Sequence[float],
    views: Mapping[str, Sequence[View]],
) -> None:
    """Draw three views of a vehicle as a PNG. views: fields of view by name. Raises OSError."""
    vertices, triangles = vehicle_hull(model)
    size = np.ptp(vertices, axis=0)
    length_m = REACH * float(size.max())
    figure = new_figure(11.0, 9.0)
    grid = figure.add_gridspec(2, 2, hspace=0.28, wspace=0.2)
    places = (grid[0, 0], grid[1, 0], grid[1, 1])
    for place, (title, pair, across, up) in zip(places, PLANES, strict=True):
        axes = figure.add_subplot(place)
        axes.add_collection(
            PolyCollection(list(vertices[triangles][:, :, pair]), facecolors=HULL, edgecolors=HULL, linewidths=0.4)
        )
        for k, field in enumerate(views.values()):
            _draw_fields(axes, field, pair, length_m, COLOURS(k % 20))
        _draw_actuators(axes, actuators_spec(model), pair, float(size.max()))
        for centre, mark, name in (
            (centre_of_buoyancy_m, "^", "centre of buoyancy"),
            (centre_of_mass_m, "v", "centre of mass"),
        ):
            point = np.asarray(centre)[list(pair)]
            axes.plot(*point, mark, color=INK, markersize=6, markerfacecolor="none", label=name)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.05)
        axes.autoscale_view()
        label_axes(axes, title, across, up)
    legend = figure.add_subplot(grid[0, 1])
    legend.axis("off")
    legend.plot([], [], color=THRUSTER, linewidth=2, label="thruster, direction of positive thrust")
    legend.plot([], [], color=FIN, linewidth=3, label="fin, along its span")
    legend.plot([], [], "^", color=INK, markerfacecolor="none", label="centre of buoyancy")
    legend.plot([], [], "v", color=INK, markerfacecolor="none", label="centre of mass")
    for k, name in enumerate(views):
        legend.plot([], [], color=COLOURS(k % 20), linewidth=5, alpha=0.5, label=name)
    keep_all_labels(legend)
    legend.legend(loc="center left", fontsize=9, frameon=False, title=model.name, title_fontsize=11)
    save_figure(figure, path)


def _draw_actuators(axes: Axes, actuators: _core.ActuatorsSpec, pair: tuple[int, int], size_m: float) -> None:
    for thruster in actuators.thrusters:
        start = np.asarray(thruster.position_body_m)
        end = start + 0.18 * size_m * np.asarray(thruster.axis_body)
        axes.annotate(
            "", xy=(end[pair[0]], end[pair[1]]), xytext=(start[pair[0]], start[pair[1]]),
            arrowprops={"arrowstyle": "-|>", "color": THRUSTER, "lw": 1.8, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        axes.plot(*np.array([start, end])[:, pair].T, "o", color=THRUSTER, markersize=3, alpha=0.0)  # widens the view
        axes.plot(*start[list(pair)], "o", color=THRUSTER, markersize=4)
    for fin in actuators.fins:
        middle, span_m = np.asarray(fin.position_body_m), float(np.sqrt(fin.area_m2 * fin.aspect_ratio))
        ends = middle + np.outer([-0.5, 0.5], span_m * np.asarray(fin.span_body))
        axes.plot(*ends[:, pair].T, "-", color=FIN, linewidth=3, solid_capstyle="round")
        axes.plot(*middle[list(pair)], "o", color=FIN, markersize=3)


def _draw_fields(
    axes: Axes, views: Sequence[View], pair: tuple[int, int], length_m: float, colour: tuple[float, ...]
) -> None:
    """Draw the outlines of some fields of view: the convex hull of the projected rays."""
    for position_m, rays in views:
        points = np.vstack([position_m, position_m + length_m * rays])[:, pair]
        try:
            outline = points[ConvexHull(points).vertices]
        except (QhullError, ValueError):  # the rays coincide with a line in this view
            far = points[np.argmax(np.linalg.norm(points - points[0], axis=1))]
            axes.plot(*np.array([points[0], far]).T, color=colour, linewidth=1.2, alpha=0.7)
            continue
        axes.add_patch(Polygon(outline, facecolor=(*colour[:3], 0.13), edgecolor=(*colour[:3], 0.6), linewidth=0.8))


def draw_circles(path: Path, tracks_m: Mapping[str, Floats]) -> None:
    """Draw tracks (n, 2) from the origin, by title, as a PNG. Raises OSError."""
    figure = new_figure(5.5, 5.0)
    axes = figure.add_subplot()
    for k, (title, track) in enumerate(tracks_m.items()):
        axes.plot(*track.T, color=COLOURS(2 * k % 20), linewidth=1.3, label=title)
    axes.plot(0.0, 0.0, "o", color=INK, markersize=5)
    axes.set_aspect("equal", adjustable="datalim")
    keep_all_labels(axes)
    axes.legend(fontsize=9, frameon=False)
    label_axes(axes, "Turning from rest at the dot, from above", "x [m]", "y [m]")
    save_figure(figure, path)


def draw_eigenvalues(path: Path, values_1_s: Mapping[str, NDArray[np.complex128]]) -> None:
    """Draw eigenvalues in the complex plane, by title, as a PNG. Raises OSError."""
    figure = new_figure(5.5, 5.0)
    axes = figure.add_subplot()
    for k, (title, values) in enumerate(values_1_s.items()):
        both = np.concatenate([values, values.conj()])
        axes.plot(both.real, both.imag, "osx^"[k % 4], color=COLOURS(2 * k % 20), markerfacecolor="none", label=title)
    axes.axvline(0.0, color=FAINT_INK, linewidth=0.8)
    keep_all_labels(axes)
    axes.legend(fontsize=9, frameon=False)
    label_axes(axes, "Eigenvalues: left of the line, motion dies out", "real part [1/s]", "imaginary part [1/s]")
    save_figure(figure, path)
