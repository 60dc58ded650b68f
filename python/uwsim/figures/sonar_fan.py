"""Figure of a multibeam ping: the fan from above and, along its middle beam, from the side."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from uwsim import _core
from uwsim.figures.style import (
    ACCENT,
    FAINT_INK,
    HEIGHTS,
    INK,
    add_colour_bar,
    add_legend,
    height_range,
    label_axes,
    new_figure,
    save_figure,
)

WIDTH_IN, SECTION_IN, MAX_PLAN_ASPECT = 9.6, 3.4, 0.62
SECTION_HALF_RAD = np.radians(1.0)
MIN_SECTION_M = 4.0
WATER, GROUND = "#e6f0f6", "#b9ab98"


class FanPing(Protocol):
    """The parts of a ping needed for the figure."""

    @property
    def ranges_m(self) -> NDArray[np.floating]:
        """Ranges (beams,); inf means no echo."""

    @property
    def angles_rad(self) -> NDArray[np.floating]:
        """Angles (beams,) in the sonar's x-y plane, positive to port."""

    @property
    def world_from_sonar(self) -> NDArray[np.float64]:
        """Pose of the sonar, (4, 4)."""


def sonar_fan(path: Path, world: _core.World, ping: FanPing, range_max_m: float) -> None:
    """Draw a ping's beams and echoes, with the vehicle, over the true terrain, from above and from the side."""
    ends_m, echo = beam_ends_m(ping, range_max_m)
    figure = new_figure(WIDTH_IN, WIDTH_IN)
    plan = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    drawn_in = draw_plan(figure, plan, world, ping, ends_m, echo)
    plan.set_position((0.0, 0.0, 1.0, drawn_in / WIDTH_IN))
    section = figure.add_axes((0.0, -(SECTION_IN + 1.3) / WIDTH_IN, 1.0, SECTION_IN / WIDTH_IN))
    draw_section(section, world, ping, ends_m, echo)
    save_figure(figure, path)


def beam_ends_m(ping: FanPing, range_max_m: float) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return each beam's end (beams, 3) in the world, at its echo or the maximum range, and a mask of echoes."""
    echo = np.isfinite(ping.ranges_m) & (ping.ranges_m <= range_max_m)
    lengths = np.where(echo, ping.ranges_m, range_max_m)
    flat = np.stack([np.cos(ping.angles_rad), np.sin(ping.angles_rad), np.zeros(len(lengths))], axis=1)
    return (flat * lengths[:, None]) @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3], echo


def _level_axes(ping: FanPing) -> NDArray[np.float64]:
    """Return the starboard and forward directions as rows (2, 2), each with its components to the east and north.

    Forward is the sonar's x axis, seen from above.
    """
    ahead = ping.world_from_sonar[:2, 0]
    length = float(np.linalg.norm(ahead))
    ahead = ahead / length if length > 1e-9 else np.array([1.0, 0.0])
    return np.array([[ahead[1], -ahead[0]], ahead])


def draw_plan(
    figure: Figure,
    axes: Axes,
    world: _core.World,
    ping: FanPing,
    ends_m: NDArray[np.float64],
    echo: NDArray[np.bool_],
) -> float:
    """Draw the fan seen from above, forward up; return the height in inches at which both axes have equal scales."""
    origin, level = ping.world_from_sonar[:3, 3], _level_axes(ping)
    ends = (ends_m[:, :2] - origin[:2]) @ level.T
    low, high = np.minimum(ends.min(axis=0), 0.0), np.maximum(ends.max(axis=0), 0.0)
    margin = 0.06 * float((high - low).max())
    low, high = low - margin, high + margin
    wider = max((high - low)[1] / MAX_PLAN_ASPECT - (high - low)[0], 0.0) / 2.0
    low, high = low - np.array([wider, 0.0]), high + np.array([wider, 0.0])
    x, y = np.meshgrid(np.linspace(low[0], high[0], 480), np.linspace(low[1], high[1], 320))
    ground = world.height_at(np.stack([x.ravel(), y.ravel()], axis=1) @ level + origin[:2]).reshape(x.shape)
    heights = height_range(ground[np.isfinite(ground)])

    label_axes(axes, "One ping from above, over the true seabed", "to starboard [m]", "ahead [m]")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_facecolor(WATER)
    extent = (low[0], high[0], low[1], high[1])
    axes.imshow(ground, origin="lower", extent=extent, cmap=HEIGHTS, norm=heights, alpha=0.85, aspect="auto")
    reach = float(np.linalg.norm(ends, axis=1).max())
    for radius in np.arange(10.0, reach + 1.0, 10.0):
        axes.add_patch(Circle((0.0, 0.0), radius, fill=False, edgecolor="white", linewidth=0.7, alpha=0.55))
    _draw_beams(axes, np.zeros(2), ends, echo, every=8)
    axes.scatter(
        ends[echo, 0], ends[echo, 1], s=7, color=ACCENT, linewidths=0, zorder=4, label=f"echoes ({int(echo.sum())})"
    )
    axes.scatter(0.0, 0.0, s=120, marker="^", color="white", edgecolors=INK, zorder=5, label="vehicle")
    count = f"every eighth of {len(echo)} beams; circles each 10 m"
    axes.plot([], [], color="#8fa3b3", linewidth=1.0, label=count)
    add_legend(axes, 3)
    add_colour_bar(figure, axes, heights, HEIGHTS, "true height of the seabed, z [m]")
    return WIDTH_IN * float((high - low)[1] / (high - low)[0])


def draw_section(
    axes: Axes, world: _core.World, ping: FanPing, ends_m: NDArray[np.float64], echo: NDArray[np.bool_]
) -> None:
    """Draw the vertical plane through the middle beam: terrain, vehicle, and the beams within SECTION_HALF_RAD."""
    origin, level = ping.world_from_sonar[:3, 3], _level_axes(ping)
    near = np.abs(ping.angles_rad) <= SECTION_HALF_RAD
    ends = np.stack([(ends_m[near, :2] - origin[:2]) @ level[1], ends_m[near, 2]], axis=1)
    echo = echo[near]
    shown = np.concatenate([[[0.0, origin[2]]], ends, [[0.0, origin[2] - MIN_SECTION_M]]])
    low, high = shown.min(axis=0), shown.max(axis=0)
    metre_in = min(WIDTH_IN / (1.2 * (high - low)[0] + 1e-9), SECTION_IN / (1.5 * (high - low)[1]))
    half = np.array([WIDTH_IN, SECTION_IN]) / metre_in / 2.0
    low, high = (low + high) / 2.0 - half, (low + high) / 2.0 + half
    ahead = np.linspace(low[0], high[0], 600)
    ground = world.height_at(origin[:2] + ahead[:, None] * level[1])

    title = "The same ping from the side, along the middle beam"
    label_axes(axes, title, "ahead of the sonar [m]", "z [m]")
    axes.set_facecolor(WATER)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.fill_between(ahead, ground, low[1], color=GROUND, linewidth=0, label="true seabed")
    axes.plot(ahead, ground, color="#6d6150", linewidth=1.2)
    start = np.array([0.0, origin[2]])
    for end in ends[:: max(len(ends) // 3, 1)]:
        axes.plot(*zip(start, end, strict=True), color=ACCENT, linewidth=0.8, alpha=0.6)
    width = f"echoes within {np.degrees(SECTION_HALF_RAD):.0f} degree of the plane"
    axes.scatter(ends[echo, 0], ends[echo, 1], s=14, color=ACCENT, linewidths=0, zorder=4, label=width)
    axes.scatter(start[0], start[1], s=120, marker=">", color="white", edgecolors=INK, zorder=5, label="vehicle")
    add_legend(axes, 3)
    if high[1] < 0.0:
        place: dict[str, Any] = {
            "transform": axes.transAxes,
            "ha": "right",
            "va": "top",
            "fontsize": 9.5,
            "color": FAINT_INK,
        }
        axes.text(0.99, 0.95, f"the sonar is {-origin[2]:.1f} m deep", **place)


def _draw_beams(
    axes: Axes, start: NDArray[np.float64], ends: NDArray[np.float64], echo: NDArray[np.bool_], every: int
) -> None:
    """Draw every `every`-th beam from the start (2,) to its end (n, 2), fainter if it has no echo."""
    shown = np.arange(0, len(ends), every)
    lines = np.stack([np.broadcast_to(start, ends[shown].shape), ends[shown]], axis=1)
    colours = [(1.0, 1.0, 1.0, 0.75) if has_echo else (1.0, 1.0, 1.0, 0.25) for has_echo in echo[shown]]
    axes.add_collection(LineCollection(list(lines), colors=colours, linewidths=0.7))
