"""Figure of a scenario: the bed from above and from the south, with obstacles, start positions, station and survey."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LightSource, Normalize
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from uwsim import _core
from uwsim.figures.style import ACCENT, HEIGHTS, INK, add_colour_bar, label_axes, new_figure, save_figure
from uwsim.scenario import Scenario, start_pose
from uwsim.scenario.build.station import station_at_start

CELLS = 300
SOLID, START, STATION, SURVEY, LAND, WATER = "#d00070", ACCENT, "#f4a300", "white", "#c9b79c", "#e6f0f6"
MAX_TRIANGLES = 20_000
WIDTH_IN = 8.0


def draw_scene(path: Path, scenario: Scenario, world: _core.World) -> None:
    """Draw a scenario's scene as a PNG. Raises OSError."""
    west, south, east, north = world.terrain_extent_m
    plan_in = WIDTH_IN * (north - south) / (east - west)
    plan_in = float(np.clip(plan_in, 3.0, 12.0))
    side_in = 1.8
    figure = new_figure(WIDTH_IN, plan_in + side_in + 0.9)
    height_in = plan_in + side_in + 0.9
    above = figure.add_axes((0.0, (side_in + 0.9) / height_in, 1.0, plan_in / height_in))
    aside = figure.add_axes((0.0, 0.0, 1.0, side_in / height_in))
    solids = _solids(world)
    _draw_above(figure, above, scenario, world, solids)
    _draw_aside(aside, scenario, world, solids)
    save_figure(figure, path)


Solids = list[tuple[str, NDArray[np.float64]]]


def _solids(world: _core.World) -> Solids:
    """Return each solid's name and triangles (n, 3, 3)."""
    vertices, triangles, labels = world.surface_mesh(with_terrain=False)
    found = []
    for label in np.unique(labels):
        own = triangles[labels == label]
        found.append((world.label_names[label], vertices[own[:: 1 + len(own) // MAX_TRIANGLES]]))
    return found


def _draw_above(figure: Figure, axes: Axes, scenario: Scenario, world: _core.World, solids: Solids) -> None:
    west, south, east, north = world.terrain_extent_m
    x, y = np.linspace(west, east, CELLS), np.linspace(south, north, CELLS)
    bed = world.height_at(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)).reshape(CELLS, CELLS)
    limits = Normalize(float(bed.min()), max(min(float(bed.max()), 0.0), float(bed.min()) + 0.5), clip=True)
    shaded = LightSource(315, 50).shade(
        bed, cmap=HEIGHTS, norm=limits, vert_exag=2.0, dx=x[1] - x[0], dy=y[1] - y[0], blend_mode="soft"
    )
    axes.imshow(shaded, extent=(west, east, south, north), origin="lower", interpolation="bilinear")
    if bed.max() > 0.0 > bed.min():
        axes.contourf(x, y, bed, levels=[0.0, float(bed.max())], colors=[LAND], alpha=0.75)
        axes.contour(x, y, bed, levels=[0.0], colors=[INK], linewidths=0.8)
    for name, triangles in solids:
        colour = STATION if name == "station" else SOLID
        _add_triangles(axes, triangles[:, :, :2], colour)
        if name != "station":
            middle = triangles[np.argmin(np.abs(triangles[:, 0, 0] - np.median(triangles[:, 0, 0])))][0]
            _label(axes, name, middle[:2], colour)
    if scenario.survey is not None:
        corners = np.asarray([*scenario.survey.area_m, scenario.survey.area_m[0]])
        axes.plot(*corners.T, "--", color=SURVEY, linewidth=1.4)
        _label(axes, "survey", corners[0], INK)
    station = station_at_start(scenario).position_m
    axes.plot(*station[:2], "^", color=STATION, markeredgecolor="white", markersize=9)
    _label(axes, "station", station[:2], STATION)
    span = max(east - west, north - south)
    for entry in scenario.vehicles:
        (vx, vy, _), yaw = start_pose(scenario, entry)
        axes.annotate(
            "", xy=(vx + 0.05 * span * np.cos(yaw), vy + 0.05 * span * np.sin(yaw)), xytext=(vx, vy),
            arrowprops={"arrowstyle": "-|>", "color": START, "lw": 2},
        )  # fmt: skip
        axes.plot(vx, vy, "o", color=START, markeredgecolor="white", markersize=6)
        _label(axes, entry.name, (vx, vy), START, below=True)
    axes.set_xlim(west, east)
    axes.set_ylim(south, north)
    axes.set_aspect("equal")
    add_colour_bar(figure, axes, limits, HEIGHTS, "height of the bed, z [m]")
    label_axes(axes, f"{scenario.name} from above", "east [m]", "north [m]")


def _add_triangles(axes: Axes, corners: NDArray[np.float64], colour: str) -> None:
    axes.add_collection(PolyCollection(list(corners), facecolors=colour, edgecolors=colour, linewidths=0.3))


def _label(axes: Axes, text: str, at: Sequence[float] | NDArray[np.float64], colour: str, below: bool = False) -> None:
    axes.annotate(
        text, xy=(float(at[0]), float(at[1])), xytext=(6, -13 if below else 6), textcoords="offset points",
        color=colour, fontsize=8.5, fontweight="bold", path_effects=[withStroke(linewidth=2.5, foreground="white")],
    )  # fmt: skip


def _draw_aside(axes: Axes, scenario: Scenario, world: _core.World, solids: Solids) -> None:
    """Draw the deepest point of the bed at each x, from west to east, and everything in the water."""
    west, south, east, north = world.terrain_extent_m
    x, y = np.linspace(west, east, CELLS), np.linspace(south, north, CELLS)
    bed = world.height_at(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)).reshape(CELLS, CELLS)
    low = bed.min(axis=0)
    every = np.concatenate([triangles[:, :, 2].ravel() for _, triangles in solids] or [np.zeros(1)])
    bottom, top = min(float(low.min()), float(every.min())), max(1.0, float(every.max()))
    bottom, top = bottom - 0.08 * (top - bottom), top + 0.08 * (top - bottom)
    axes.fill_between(x, low, 0.0, where=low < 0.0, color=WATER, linewidth=0)
    axes.fill_between(x, bottom, low, color=LAND, linewidth=0)
    axes.plot(x, low, color=INK, linewidth=0.9)
    axes.axhline(0.0, color="#2a6f97", linewidth=1.2)
    for name, triangles in solids:
        colour = STATION if name == "station" else SOLID
        _add_triangles(axes, triangles[:, :, [0, 2]], colour)
    for entry in scenario.vehicles:
        (vx, _, vz), _ = start_pose(scenario, entry)
        axes.plot(vx, vz, "o", color=START, markeredgecolor="white", markersize=6)
        _label(axes, entry.name, (vx, vz), START)
    axes.set_xlim(west, east)
    axes.set_ylim(bottom, top)
    label_axes(axes, "From the south, over the deepest bed at each x", "east [m]", "z [m]")
