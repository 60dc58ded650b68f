"""Plots of imaging sonars' results, for notebooks and `plot()`; up is ahead, and port is on the left."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from uwsim.instruments.sonars.imaging.pixels import polar_pixels, shown_range

if TYPE_CHECKING:
    from uwsim.instruments.sonars.imaging.forward_looking import SonarImage
    from uwsim.instruments.sonars.imaging.side_scan import Waterfall
    from uwsim.instruments.sonars.imaging.single_beam import Profiles

SIZE_IN = (6.0, 4.5)
PIXELS = 600
COLOURS = "inferno"


def plot_fan(image: SonarImage) -> Figure:
    """Return a figure of a forward-looking sonar's picture in the sonar's plane."""
    model = image.model
    fan = polar_pixels(image.level_db, model.range_max_m, model.field_of_view_rad, PIXELS)
    half_rad = 0.5 * model.field_of_view_rad
    half_m = model.range_max_m * float(np.sin(min(half_rad, 0.5 * np.pi)))
    back_m = min(model.range_max_m * float(np.cos(half_rad)), 0.0)
    extent_m = (-half_m, half_m, back_m, model.range_max_m)
    limits = shown_range(image.level_db, image.noise_db[:, None])
    return _picture(fan.level_db, extent_m, limits, repr(image), "to starboard [m]", "ahead [m]")


def plot_waterfall(waterfall: Waterfall) -> Figure:
    """Return a figure of side-scan lines, the first at the top, over slant range, port on the left."""
    reach_m = waterfall.model.range_max_m
    levels = waterfall.picture_db()
    extent_m = (-reach_m, reach_m, len(levels) - 0.5, -0.5)
    noise_db = np.concatenate([waterfall.noise_db[::-1], waterfall.noise_db])[None]
    limits = shown_range(levels, noise_db)
    return _picture(levels, extent_m, limits, repr(waterfall), "slant range to starboard [m]", "ping", is_square=False)


def plot_profiles(profiles: Profiles) -> Figure:
    """Return a figure of a single-beam sonar's levels by direction and range, with its detections as dots."""
    degrees = np.degrees(profiles.angles_rad)
    order = np.argsort(degrees)
    extent = (float(degrees.min()) - 0.5, float(degrees.max()) + 0.5, 0.0, profiles.model.range_max_m)
    levels = profiles.level_db[order].T[::-1]
    limits = shown_range(profiles.level_db, profiles.noise_db[None])
    title = repr(profiles)
    figure = _picture(levels, extent, limits, title, "direction, to port [deg]", "range [m]", is_square=False)
    figure.axes[0].plot(degrees, profiles.ranges_m, ".", color="#4cc9f0", markersize=3)
    return figure


def _picture(
    level_db: NDArray[np.float32],
    extent: tuple[float, float, float, float],
    limits_db: tuple[float, float],
    title: str,
    across: str,
    up: str,
    is_square: bool = True,
) -> Figure:
    figure = Figure(SIZE_IN, layout="constrained")
    axes: Axes = figure.add_subplot()
    low, high = limits_db
    shown = axes.imshow(level_db, extent=extent, vmin=low, vmax=high, cmap=COLOURS, interpolation="nearest")
    axes.set(xlabel=across, ylabel=up, title=title, aspect="equal" if is_square else "auto")
    axes.title.set_fontsize(9)
    figure.colorbar(shown, label="level [dB re 1 uPa]")
    return figure


def png(figure: Figure) -> bytes:
    """Return a figure as a PNG file."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=100)
    return file.getvalue()
