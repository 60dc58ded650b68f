"""The reports of `uwsim ardusub check`: two firmwares side by side, or a log beside the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.bridges.firmware.check import UNITS, Flown
from uwsim.bridges.firmware.dataflash_log import QUANTITIES, Compared

Row = tuple[str, ...]


def side_rows(flights: Sequence[Flown], sides: Sequence[str]) -> list[Row]:
    """Return a table: mean and standard deviation over the seeds, and the mean difference with its standard error.

    Differences are between flights of the same seed.
    """
    rows: list[Row] = [("in each flight", "unit", *sides, "difference")]
    for name, unit in UNITS.items():
        values = [{each.seed: each.values[name] for each in flights if each.side == side} for side in sides]
        both = sorted(values[0].keys() & values[1].keys())
        gaps = [values[1][seed] - values[0][seed] for seed in both]
        shown = [_mean(list(each.values())) for each in values]
        rows.append((name, unit, *shown, _mean(gaps, of_mean=True)))
    return rows


def log_rows(found: Compared) -> list[Row]:
    """Return a table: the log's own rms about its mean, the rms of model minus log, and their correlation."""
    rows: list[Row] = [("quantity", "unit", "log, rms about its mean", "model minus log, rms", "correlation")]
    for name, unit in QUANTITIES.items():
        logged, modelled = found.logged[name], found.modelled[name]
        spread, error = float(np.std(logged)), float(np.sqrt(np.mean((modelled - logged) ** 2)))
        flat = min(spread, float(np.std(modelled))) < 1e-9
        correlation = "" if flat else f"{np.corrcoef(logged, modelled)[0, 1]:.2f}"
        rows.append((name, unit, f"{spread:.3g}", f"{error:.3g}", correlation))
    return rows


def text_of(rows: Sequence[Row]) -> str:
    """Return a table for a terminal."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    padded = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in padded)


def write_report(folder: Path, title: str, about: str, rows: Sequence[Row], picture: str) -> Path:
    """Write report.md with a table and a picture. Raises OSError."""
    head, *rest = rows
    lines = [f"# {title}", "", about, "", f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    lines += [f"| {' | '.join(row)} |" for row in rest]
    path = folder / "report.md"
    write_atomically(path, "\n".join([*lines, "", f"![{title}]({picture})", ""]).encode())
    return path


def draw_depths(path: Path, flights: Sequence[Flown], sides: Sequence[str]) -> None:
    """Draw the depth of each flight over time; flights of one side share a colour. Raises OSError."""
    from uwsim.figures.style import add_legend, label_axes, new_figure, save_figure

    figure = new_figure(9.6, 4.4)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, "Depth in each flight", "simulated time [s]", "depth [m]")
    for k, side in enumerate(sides):
        for number, each in enumerate(one for one in flights if one.side == side):
            label = side if number == 0 else None
            axes.plot(each.times_s, each.depths_m, color=f"C{k}", linewidth=1.2, alpha=0.8, label=label)
    axes.invert_yaxis()
    add_legend(axes, 2)
    save_figure(figure, path)


def draw_log(path: Path, found: Compared) -> None:
    """Draw each quantity of a log over time, and the model's from the beginning of each window. Raises OSError."""
    from uwsim.figures.style import label_axes, new_figure, save_figure

    figure = new_figure(9.6, 11.0)
    times_s = found.times_s - found.times_s[0]
    for k, (name, unit) in enumerate(QUANTITIES.items()):
        axes = figure.add_subplot(3, 2, k + 1)
        last = "time since arming [s]" if k >= len(QUANTITIES) - 2 else ""
        label_axes(axes, f"{name} [{unit}]", last, "")
        modelled = found.modelled[name].copy()
        modelled[found.starts[1:]] = math.nan  # each window is a line of its own
        axes.plot(times_s, found.logged[name], color="C0", linewidth=1.0, label="log")
        axes.plot(times_s, modelled, color="C1", linewidth=1.0, label="model")
    figure.axes[0].legend(loc="upper left", frameon=False)
    save_figure(figure, path)


def write_flights(path: Path, flights: Sequence[Flown]) -> None:
    """Write the values of each flight as CSV. Raises OSError."""
    head = ["side", "seed", *(f"{name} [{unit}]".replace(",", "") for name, unit in UNITS.items())]
    rows = [[each.side, str(each.seed), *(f"{each.values[name]:.6g}" for name in UNITS)] for each in flights]
    write_atomically(path, "".join(f"{','.join(row)}\n" for row in [head, *rows]).encode())


def _mean(values: Sequence[float], *, of_mean: bool = False) -> str:
    known = [value for value in values if math.isfinite(value)]
    if not known:
        return "not known"
    if len(known) == 1:
        return f"{known[0]:.3g}"
    spread = float(np.std(known, ddof=1)) / (math.sqrt(len(known)) if of_mean else 1.0)
    return f"{np.mean(known):.3g} ± {spread:.2g}"
