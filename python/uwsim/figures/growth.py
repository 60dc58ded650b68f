"""Figure of a map's growth: its area and its distance from the true surface over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from uwsim.figures.flight import WIDTH_IN
from uwsim.figures.style import ACCENT, INK, add_legend, label_axes, new_figure, save_figure


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
