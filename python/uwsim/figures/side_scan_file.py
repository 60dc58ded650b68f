"""Draws the side scan of a survey file: a waterfall, one row for each ping."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib.colors import LinearSegmentedColormap

from uwsim.base.arrays import Floats
from uwsim.base.atomic_file import write_atomically
from uwsim.base.plain_figure import PlainFigure
from uwsim.figures.style import ACCENT, label_axes
from uwsim.instruments.sonars.imaging.pixels import AMBER, NIGHT
from uwsim.instruments.sonars.imaging.plots import png
from uwsim.mapping.files.side_scan_line import Levels, SideScanHead, SideScanLine

MOST_ROWS = 4000
SHARES = 2.0, 99.5  # percentiles of the levels that are black and white


def draw_side_scan(
    path: Path, head: SideScanHead, lines: Iterable[SideScanLine], title: str, *, over_ground: bool = False
) -> int:
    """Draw the lines, the first at the bottom, port on the left; return their number. Raises OSError.

    Of more than MOST_ROWS lines, neighbours are averaged. over_ground: by range over a level bed at the altitude of the
    first return instead of slant range; without an altitude, a line stays as it is. Raises ValueError without a level.
    """
    rows: list[Levels] = []
    altitudes: list[float] = []
    for line in lines:
        port, starboard = line.port_db, line.starboard_db
        if over_ground and np.isfinite(line.altitude_m):
            port, starboard = (_over_ground(side, line.altitude_m, head.range_max_m) for side in (port, starboard))
        rows.append(np.concatenate([port[::-1], starboard]))
        altitudes.append(line.altitude_m)
    count, levels = len(rows), np.stack(rows)
    if not np.isfinite(levels).any():
        raise ValueError(f"{title}: no sample of its {count} pings is above zero")
    together = -(-count // MOST_ROWS)
    levels = _averaged(levels, together)
    figure = PlainFigure((8.0, 9.0), layout="constrained")
    axes = figure.add_subplot()
    axes.set_facecolor(NIGHT)
    low, high = np.nanpercentile(levels, SHARES)
    reach = head.range_max_m
    axes.imshow(
        np.ma.masked_invalid(levels), extent=(-reach, reach, 0.0, count), vmin=low, vmax=max(high, low + 1.0),
        cmap=LinearSegmentedColormap.from_list("amber", AMBER), aspect="auto", origin="lower",
        interpolation="antialiased",
    )  # fmt: skip
    if not over_ground:
        for side in (-1.0, 1.0):
            axes.plot(side * np.array(altitudes), np.arange(count) + 0.5, color=ACCENT, linewidth=0.6, alpha=0.8)
    what = "range over ground" if over_ground else "slant range"
    label_axes(axes, f"{title}: {count:,} pings, {head.frequency_hz / 1e3:.0f} kHz",
               f"port            {what} [m]            starboard", "ping")  # fmt: skip
    write_atomically(path, png(figure))
    return count


def _over_ground(side: Levels, altitude_m: float, reach_m: float) -> Levels:
    """Return levels by range over ground: at x, those of slant range sqrt(x^2 + h^2)."""
    bins = len(side)
    slant_m = np.hypot((np.arange(bins) + 0.5) * reach_m / bins, altitude_m)
    index = np.floor(slant_m * bins / reach_m).astype(int)
    return np.where(index < bins, side[np.minimum(index, bins - 1)], np.float32(np.nan)).astype(np.float32)


def _averaged(levels: Floats | Levels, together: int) -> Levels:
    """Return the mean power of each few rows, as levels."""
    if together == 1:
        return np.asarray(levels, np.float32)
    full = len(levels) // together * together
    power = np.where(np.isfinite(levels[:full]), 10.0 ** (levels[:full].astype(np.float64) / 10.0), 0.0)
    mean = power.reshape(-1, together, levels.shape[1]).mean(axis=1)
    with np.errstate(divide="ignore"):
        return np.where(mean > 0.0, 10.0 * np.log10(mean), np.nan).astype(np.float32)
