"""The world from above, and the release from the station (Figs. 3 and 6)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle

from uwsim.evidence.reproduce.figure import Figure
from uwsim.figures.style import ACCENT, HEIGHTS, INK, add_colour_bar, height_range, label_axes, new_figure, save_figure
from uwsim.missions.published_mower import START_M
from uwsim.scenario.spec.obstacle import Box, Gate, Pipeline
from uwsim.simulator.simulator import Simulator

HALF_M, SPACING_M = 200.0, 1.0
PUBLISHED_SURFACE_M = 75.3
RELEASE_S, SAMPLE_S = 60.0, 0.05


def place(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 3, the world from above."""
    along = np.arange(-HALF_M, HALF_M + SPACING_M, SPACING_M)
    x, y = np.meshgrid(along, along)
    heights = sim.world.height_at(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(x.shape)
    figure = new_figure(8.0, 7.4)
    axes = figure.add_axes((0.0, 0.0, 0.95, 1.0))
    limits = height_range(heights)
    axes.imshow(heights, extent=(-HALF_M, HALF_M, -HALF_M, HALF_M), origin="lower", cmap=HEIGHTS, norm=limits)
    axes.contour(x, y, heights, levels=[0.0], colors="white", linewidths=1.0)
    rows: list[tuple[object, ...]] = []
    for item in sim.scenario.obstacles:
        if isinstance(item, Box):
            low = np.subtract(item.position_m, np.divide(item.size_m, 2.0))
            axes.add_patch(Rectangle((low[0], low[1]), item.size_m[0], item.size_m[1], color="white"))
            rows.append((item.name, item.kind, *item.position_m[:2]))
        elif isinstance(item, Pipeline):
            axes.plot(*np.transpose(item.points_m), color=ACCENT, linewidth=2.0)
            rows.append((item.name, item.kind, *item.points_m[0]))
        elif isinstance(item, Gate):
            axes.plot(*item.position_m, "s", color=ACCENT, markersize=6)
            rows.append((item.name, item.kind, *item.position_m))
    marks = {"station": sim.scenario.station.position_m[:2], "lawn-mower's start": START_M[:2]}
    for name, (east_m, north_m) in marks.items():
        axes.plot(east_m, north_m, "o", color="white", markeredgecolor=INK, markersize=7)
        axes.annotate(name, (east_m, north_m), (6, 6), textcoords="offset points", fontsize=9, color="white")
        rows.append((name, "mark", east_m, north_m))
    label_axes(axes, "The scenario `paper` from above", "east [m]", "north [m]")
    add_colour_bar(figure, axes, limits, HEIGHTS, "height of the bed, z [m]")
    save_figure(figure, path)
    land = float(np.mean(heights > 0.0))
    return Figure(
        3, "The place", "Bed, mountains, walls, pipeline, gate and station; the white line is the shore.",
        values={"deepest_m": float(-heights.min()), "highest_m": float(heights.max()), "land_share": round(land, 4)},
        columns=("what", "kind", "east [m]", "north [m]"), rows=rows,
    )  # fmt: skip


def release(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 6, the release."""
    sim.reset()
    rov, rows = sim.rov, []
    rov.release()
    for _ in range(round(RELEASE_S / SAMPLE_S)):
        rows.append((round(sim.time_s, 3), float(rov.pose.position_world_m[2]), _vertical_m_s(sim)))
        sim.advance(SAMPLE_S)
    time_s, height_m, speed_m_s = np.transpose(rows)
    figure = new_figure(8.0, 5.4)
    upper, lower = figure.add_axes((0.0, 0.56, 1.0, 0.44)), figure.add_axes((0.0, 0.0, 1.0, 0.44))
    upper.axhline(0.0, color="#4b8bbe", linewidth=1.0)
    upper.plot(time_s, height_m, color=ACCENT)
    label_axes(upper, "Released from the davit, left alone", "", "height [m]")
    lower.plot(time_s, speed_m_s, color=INK)
    label_axes(lower, "", "time since the release [s]", "vertical speed [m/s]")
    save_figure(figure, path)
    return Figure(
        6, "The release", "The vehicle falls into the water, and stays at the depth where its motion ends.",
        values={"fastest_fall_m_s": float(-speed_m_s.min()), "deepest_m": float(-height_m.min()),
                "rests_at_m": float(-height_m[-1])},
        columns=("time [s]", "height [m]", "vertical speed [m/s]"), rows=rows[::20],
    )  # fmt: skip


def _vertical_m_s(sim: Simulator) -> float:
    return float(sim.rov.pose.world_from_body[2, :3] @ sim.rov.velocity.linear_body_m_s)
