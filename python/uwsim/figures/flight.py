"""Figures of a flight: track, depth and altitude, commands and battery, estimation error, and the map's growth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from uwsim import _core
from uwsim.figures.style import (
    ACCENT,
    HEIGHTS,
    INK,
    add_colour_bar,
    add_legend,
    height_range,
    label_axes,
    new_figure,
    save_figure,
)
from uwsim.figures.style import save_figure as save

WIDTH_IN = 4.4  # narrow, so that text is legible on a phone
TRACKS = (ACCENT, "#00b4d8", "#d00070", "#f4a300", "#80ed99")
GROUND, GROUND_LINE, WATER, ALARM = "#b9ab98", "#6d6150", "#e6f0f6", "#d62828"
CELLS = 220
Paths = Mapping[str, NDArray[np.float64]]


def draw_track(
    path: Path,
    world: _core.FixedWorld | _core.World | None,
    tracks_world_m: Paths,
    estimates_world_m: Paths,
    *,
    places_world_m: Paths | None = None,
    marks: Sequence[tuple[str, str, str, float, float]] = (),
) -> None:
    """Draw tracks (n, 3) by vehicle over the true bed, estimates dashed. Raises OSError.

    world: None if the bed is unknown. places_world_m: points (n, 2) by name, labelled. marks: symbol, colour, legend,
    x and y.
    """
    paths = (*tracks_world_m.values(), *estimates_world_m.values())
    places = places_world_m or {}
    every = np.concatenate([*(track[:, :2] for track in paths), *places.values()])
    low, high = every.min(axis=0), every.max(axis=0)
    size = max(float((high - low).max()), 10.0)
    middle, half = (low + high) / 2.0, np.maximum((high - low) / 2.0, 0.3 * size) + 0.12 * size
    (west, south), (east, north) = middle - half, middle + half
    figure = new_figure(WIDTH_IN, WIDTH_IN * float(half[1] / half[0]))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, "Track over the true bed" if world is not None else "Track", "east [m]", "north [m]")
    axes.set_facecolor(WATER)
    axes.set_aspect("equal")
    if world is not None:
        _draw_bed(figure, axes, world, (west, east), (south, north))
    outline = [withStroke(linewidth=3.2, foreground="white")]
    thin: dict[str, Any] = {"linewidth": 1.2, "path_effects": [withStroke(linewidth=2.4, foreground=INK)]}
    for colour, (name, track) in zip(_colours(len(tracks_world_m)), tracks_world_m.items(), strict=True):
        axes.plot(track[:, 0], track[:, 1], color=colour, linewidth=1.8, label=name, path_effects=outline)
        axes.plot(*track[0, :2], "o", color=colour, markersize=6, markeredgecolor="white")
        axes.plot(*track[-1, :2], "s", color=colour, markersize=6, markeredgecolor="white")
        if name in estimates_world_m:
            estimate = estimates_world_m[name]
            axes.plot(estimate[:, 0], estimate[:, 1], "--", color="white", label=f"{name}, estimated", **thin)
    for name, points in places.items():
        axes.plot(points[:, 0], points[:, 1], "o:", color="white", mfc="none", markersize=9, markeredgewidth=1.6)
        axes.annotate(
            name.replace("_", " "), points[0], xytext=(7, 6), textcoords="offset points", color="white", fontsize=8,
            path_effects=[withStroke(linewidth=2.4, foreground=INK)],
        )  # fmt: skip
    labelled = set[str]()
    for symbol, colour, text, x, y in marks:
        label = text if text not in labelled else None
        axes.plot(x, y, symbol, color=colour, markersize=8, markeredgewidth=2.0, label=label, path_effects=outline)
        labelled.add(text)
    axes.set_xlim(west, east)
    axes.set_ylim(south, north)
    add_legend(axes, 2)
    save(figure, path)


def _draw_bed(
    figure: Figure,
    axes: Axes,
    world: _core.FixedWorld | _core.World,
    east_m: tuple[float, float],
    north_m: tuple[float, float],
) -> None:
    x, y = np.linspace(*east_m, CELLS), np.linspace(*north_m, CELLS)
    bed_m = world.height_at(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)).reshape(CELLS, CELLS)
    known = np.isfinite(bed_m)
    limits = height_range(bed_m[known])
    filled = np.where(known, bed_m, bed_m[known].min() if known.any() else 0.0)
    shaded = LightSource(315, 50).shade(
        filled, cmap=HEIGHTS, norm=limits, vert_exag=2.0, dx=x[1] - x[0], dy=y[1] - y[0], blend_mode="soft"
    )
    axes.imshow(shaded, extent=(*east_m, *north_m), origin="lower", interpolation="bilinear")
    add_colour_bar(figure, axes, limits, HEIGHTS, "height of the bed, z [m]")


def draw_depth(
    path: Path,
    time_s: NDArray[np.float64],
    z_m: NDArray[np.float64],
    bed_m: NDArray[np.float64],
    collided: NDArray[np.bool_],
) -> None:
    """Draw the z of the vehicle and of the bed below it over time, (n,) each, and mark contacts. Raises OSError."""
    figure, axes = _over_time("Depth and altitude", "z [m], 0 is the surface", time_s, 2.5)
    minutes = time_s / 60.0
    lowest = float(np.nanmin(np.append(bed_m[np.isfinite(bed_m)], z_m)))
    axes.set_facecolor(WATER)
    axes.set_ylim(1.08 * lowest - 0.5, max(0.0, float(z_m.max())) + 0.02 * abs(lowest))
    axes.fill_between(minutes, bed_m, axes.get_ylim()[0], color=GROUND, linewidth=0, label="bed below")
    axes.plot(minutes, bed_m, color=GROUND_LINE, linewidth=0.8)
    axes.plot(minutes, z_m, color=ACCENT, linewidth=1.5, label="vehicle")
    if collided.any():
        axes.plot(minutes[collided], z_m[collided], "x", color=ALARM, markersize=5, label="in contact")
    add_legend(axes, 3)
    save(figure, path)


def draw_power(
    path: Path,
    time_s: NDArray[np.float64],
    commands: NDArray[np.float64],
    names: Sequence[str],
    battery_percent: NDArray[np.float64],
) -> None:
    """Draw each command (n, thrusters or axes) and the battery charge (n,) over time. Raises OSError."""
    figure, axes = _over_time("Commands and battery", "", time_s, max(1.6, 0.22 * len(names)))
    end = max(float(time_s[-1]), 1.0) / 60.0
    image = axes.imshow(
        commands.T, aspect="auto", cmap="RdBu_r", vmin=-1.0, vmax=1.0, interpolation="nearest",
        extent=(float(time_s[0]) / 60.0, end, len(names) - 0.5, -0.5),
    )  # fmt: skip
    axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names], fontsize=9)
    bar = figure.colorbar(image, cax=axes.inset_axes((1.02, 0.0, 0.02, 1.0)))
    bar.set_label("command", fontsize=9.5, color=INK)
    charge = axes.inset_axes((0.0, -0.95, 1.0, 0.45))
    axes.tick_params(labelbottom=False)
    axes.set_xlabel("")
    label_axes(charge, "", "time [min]", "battery [%]")
    charge.plot(time_s / 60.0, battery_percent, color="#2a9d8f", linewidth=1.6)
    charge.set_xlim(axes.get_xlim())
    charge.set_ylim(0.0, 105.0)
    save(figure, path)


def draw_estimate(path: Path, errors: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]]) -> None:
    """Draw distances [m] from the true position against time [s]. errors: times and distances (n,), by name.

    Raises OSError.
    """
    draw_curves(path, "Estimate against truth", "distance [m]", errors)


def draw_budget(path: Path, budget_m: Mapping[str, NDArray[np.float64]]) -> None:
    """Draw standard deviations (3,) of a position [m] by source, horizontal and vertical. Raises OSError."""
    names = sorted(budget_m, key=lambda name: -float(np.linalg.norm(budget_m[name])))
    rows = np.arange(len(names))
    figure = new_figure(WIDTH_IN, 0.24 * len(names) + 0.4)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, "Which metre comes from what", "standard deviation [m]", "")
    level_m = [float(np.hypot(*budget_m[name][:2])) for name in names]
    axes.barh(rows - 0.2, level_m, 0.4, color=ACCENT, label="horizontal")
    axes.barh(rows + 0.2, [float(budget_m[name][2]) for name in names], 0.4, color=GROUND_LINE, label="vertical")
    axes.set_yticks(rows, names, fontsize=9)
    axes.invert_yaxis()
    add_legend(axes, 2)
    save(figure, path)


def draw_curves(
    path: Path, title: str, label: str, curves: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]]
) -> None:
    """Draw values, from 0 upwards, against time [s]. curves: times and values (n,), by name. Raises OSError."""
    times_s = np.sort(np.concatenate([time_s for time_s, _ in curves.values()]))
    figure, axes = _over_time(title, label, times_s, 2.2)
    for colour, (name, (time_s, values)) in zip(_colours(len(curves)), curves.items(), strict=True):
        axes.plot(time_s / 60.0, values, color=colour, linewidth=1.4, label=name)
    axes.set_ylim(bottom=0.0)
    add_legend(axes, 3)
    save(figure, path)


def _over_time(title: str, label: str, time_s: NDArray[np.float64], height_in: float) -> tuple[Figure, Axes]:
    figure = new_figure(WIDTH_IN, height_in)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, title, "time [min]", label)
    begin, end = float(time_s[0]) / 60.0, float(time_s[-1]) / 60.0
    axes.set_xlim(begin, max(end, begin + 0.01))
    return figure, axes


def _colours(count: int) -> list[str]:
    return [TRACKS[k % len(TRACKS)] for k in range(count)]


def draw_growth(path: Path, rows: Sequence[Mapping[str, float]]) -> None:
    """Draw rows containing time_s, area_m2, distance_mean_m and distance_p95_m. Raises OSError."""
    figure = new_figure(WIDTH_IN, 3.6)
    minutes = [row["time_s"] / 60.0 for row in rows]
    area, distance = figure.add_axes((0.0, 0.58, 1.0, 0.42)), figure.add_axes((0.0, 0.0, 1.0, 0.42))
    label_axes(area, "Growth of the map", "", "area [m2]")
    area.plot(minutes, [row["area_m2"] for row in rows], color=ACCENT, marker=".")
    label_axes(distance, "", "time [min]", "to the truth [m]")
    distance.plot(minutes, [row["distance_mean_m"] for row in rows], color=ACCENT, marker=".", label="mean")
    distance.plot(minutes, [row["distance_p95_m"] for row in rows], color=INK, linestyle="--", label="95 % within")
    for axes in (area, distance):
        axes.set_ylim(bottom=0.0)
    add_legend(distance, 2)
    save_figure(figure, path)


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
