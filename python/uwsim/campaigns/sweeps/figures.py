"""Pictures for a sweep report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from uwsim.campaigns.sweeps.rows import Rows
from uwsim.campaigns.sweeps.sensitivity import Sensitivity
from uwsim.campaigns.sweeps.spec import SweepSpec
from uwsim.figures.style import ACCENT, INK, label_axes, new_figure, save_figure

ACROSS = 3
PANEL_IN = 3.6, 2.7
BLUE = "#2f6f9f"


def draw_distributions(path: Path, rows: Rows, metrics: Sequence[str]) -> None:
    """Draw a histogram of each metric, marking the median."""
    figure, panels = _panels(len(metrics))
    for axes, metric in zip(panels, metrics, strict=True):
        values = rows.numbers(metric)
        values = values[np.isfinite(values)]
        axes.hist(values, bins=min(30, max(5, int(math.sqrt(len(values)) * 2))), color=BLUE)
        axes.axvline(float(np.median(values)), color=ACCENT, linewidth=1.5)
        of = "" if len(values) == len(rows) else f" of {len(values):,} of {len(rows):,} runs"
        label_axes(axes, metric, f"median {np.median(values):.4g}{of}", "runs")
    save_figure(figure, path)


def draw_effects(path: Path, spec: SweepSpec, rows: Rows, metric: str, varied: Sequence[str]) -> None:
    """Draw a metric against each variation: points and means for numbers, box plots for choices."""
    figure, panels = _panels(len(varied))
    y = rows.numbers(metric)
    for axes, name in zip(panels, varied, strict=True):
        if rows.is_numeric(name):
            x = rows.numbers(name)
            axes.plot(x, y, ".", color=BLUE, alpha=0.5, markersize=5, markeredgewidth=0)
            _means(axes, x, y)
            if spec.vary[name].scale == "log":
                axes.set_xscale("log")
                axes.xaxis.set_minor_formatter(NullFormatter())
        else:
            labels = list(dict.fromkeys(str(row.get(name)) for row in rows.rows))
            of = [str(row.get(name)) for row in rows.rows]
            known = [(label, v) for label, v in zip(of, y, strict=True) if np.isfinite(v)]
            groups = [[v for label, v in known if label == each] for each in labels]
            short = [Path(label).name if "/" in label else label for label in labels]
            axes.boxplot(groups, tick_labels=short, medianprops={"color": ACCENT})
            axes.tick_params(axis="x", labelrotation=20)
        label_axes(axes, "", name, metric)
    save_figure(figure, path)


def draw_sensitivity(path: Path, found: Sensitivity) -> None:
    """Draw the sensitivity table as a heat map."""
    rows, columns = found.values.shape
    figure = new_figure(2.4 + 1.15 * columns, 1.4 + 0.42 * rows)
    axes = figure.add_subplot()
    image = axes.imshow(found.values, cmap=matplotlib.colormaps["RdBu_r"], vmin=-1.0, vmax=1.0, aspect="auto")
    names = [n if k == "rank" else f"{n}\n(share)" for n, k in zip(found.varied, found.kinds, strict=True)]
    axes.set_xticks(range(columns), names, rotation=20, ha="right", fontsize=9, color=INK)
    axes.set_yticks(range(rows), found.metrics, fontsize=9, color=INK)
    for row in range(rows):
        for column in range(columns):
            value = found.values[row, column]
            text = "-" if math.isnan(value) else f"{value:.2f}"
            strong = not math.isnan(value) and abs(value) > 0.6
            axes.text(column, row, text, ha="center", va="center", fontsize=9, color="white" if strong else INK)
    figure.colorbar(image, ax=axes, fraction=0.05, pad=0.03).ax.tick_params(labelsize=8)
    save_figure(figure, path)


def _panels(count: int) -> tuple[Any, list[Axes]]:
    across = min(ACROSS, count)
    down = math.ceil(count / across)
    figure = new_figure(PANEL_IN[0] * across, PANEL_IN[1] * down)
    panels = [figure.add_subplot(down, across, k + 1) for k in range(count)]
    figure.subplots_adjust(wspace=0.38, hspace=0.55)
    return figure, panels


def _means(axes: Axes, x: Any, y: Any) -> None:
    """Draw means over groups of equal size, or for each value if there are only a few."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if len(x) < 4:
        return
    places = np.unique(x)
    if len(places) <= min(12, len(x) // 2):
        groups = [x == place for place in places]
    else:
        order = np.argsort(x, kind="stable")
        groups = [np.isin(np.arange(len(x)), part) for part in np.array_split(order, min(10, len(x) // 4 or 1))]
    middles = [(x[g].mean(), y[g].mean()) for g in groups if g.any()]
    axes.plot(*zip(*middles, strict=True), "-o", color=ACCENT, markersize=4, linewidth=1.5)
