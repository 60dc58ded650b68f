"""Draws imaging sonar results into axes, with one function per kind of sonar."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import Arc
from numpy.typing import NDArray

from uwsim.figures.style import ACCENT, add_legend, label_axes
from uwsim.instruments.sonars.imaging import Profiles, SonarImage, Waterfall
from uwsim.instruments.sonars.imaging import pixels as sonar_pixels
from uwsim.instruments.sonars.imaging.pixels import NIGHT, fan_pixels, shown_range

AMBER = LinearSegmentedColormap.from_list("amber", sonar_pixels.AMBER)
RING = "#9fd3e6"
BEARING_STEP_DEG = 30.0
SHOWN_BINS = 500


def draw_image(axes: Axes, image: SonarImage) -> float:
    """Draw a forward-looking picture with range rings and bearings; return the drawing's height-to-width ratio."""
    pixels = fan_pixels(image)
    low, high = shown_range(image.level_db, image.noise_db[:, None])
    left, right, bottom, top = pixels.extent_m
    label_axes(axes, "Forward-looking sonar", "to starboard [m]", "ahead [m]")
    axes.set_facecolor(NIGHT)
    axes.imshow(
        np.ma.masked_invalid(pixels.level_db), extent=pixels.extent_m, cmap=AMBER, vmin=low, vmax=high, aspect="auto",
        interpolation="antialiased",
    )  # fmt: skip
    _draw_rings(axes, image)
    margin = 0.05 * (right - left)
    axes.set_xlim(left - margin, right + margin)
    axes.set_ylim(bottom - margin / 2, top + margin)
    axes.text(
        0.01, 0.02, f"{image.model.frequency_hz / 1e3:.0f} kHz, {image.model.beams} beams", transform=axes.transAxes,
        fontsize=9.5, color=RING,
    )  # fmt: skip
    return float((top - bottom + 1.5 * margin) / (right - left + 2 * margin))


def _draw_rings(axes: Axes, image: SonarImage) -> None:
    """Draw arcs at round ranges and spokes at round bearings, which are positive to port."""
    reach, half_deg = image.model.range_max_m, np.degrees(image.model.field_of_view_rad / 2)
    style: dict[str, Any] = {"color": RING, "alpha": 0.45, "linewidth": 0.7}
    step = _round_step(reach / 4)
    for radius in [*np.arange(step, reach - 0.2 * step, step), reach]:
        arc = Arc((0, 0), 2 * radius, 2 * radius, theta1=90 - half_deg, theta2=90 + half_deg, **style)
        axes.add_patch(arc)
        place = np.radians(half_deg)
        axes.text(
            radius * np.sin(place),
            radius * np.cos(place),
            f" {radius:g} m",
            fontsize=8,
            color=RING,
            va="top",
            ha="left",
        )
    bearings = np.arange(-np.floor(half_deg / BEARING_STEP_DEG), np.floor(half_deg / BEARING_STEP_DEG) + 1)
    for bearing in bearings * BEARING_STEP_DEG:
        x, y = -np.sin(np.radians(bearing)), np.cos(np.radians(bearing))
        axes.plot([0, reach * x], [0, reach * y], **style)
        axes.text(
            1.03 * reach * x, 1.03 * reach * y, f"{bearing:+.0f}°", fontsize=8, color=RING, ha="center", va="center"
        )


def draw_waterfall(axes: Axes, waterfall: Waterfall, spacing_m: float, *, over_ground: bool = False) -> None:
    """Draw side-scan pings, spacing_m apart, with the first at the bottom and port on the left."""
    shown = waterfall.over_ground() if over_ground else waterfall
    level_db = shown.picture_db()
    low, high = shown_range(waterfall.picture_db(), np.concatenate([waterfall.noise_db[::-1], waterfall.noise_db]))
    reach, length = waterfall.model.range_max_m, spacing_m * len(level_db)
    what = "range over ground" if over_ground else "slant range"
    label_axes(axes, "Side-scan sonar", f"port            {what} [m]            starboard", "along the track [m]")
    axes.set_facecolor(NIGHT)
    axes.imshow(
        np.ma.masked_invalid(level_db), extent=(-reach, reach, 0.0, length), cmap=AMBER, vmin=low, vmax=high,
        aspect="auto", origin="lower", interpolation="antialiased",
    )  # fmt: skip
    ticks = np.arange(0.0, reach + 1e-9, _round_step(reach / 4))
    axes.set_xticks([*-ticks[:0:-1], *ticks], [f"{abs(tick):g}" for tick in [*-ticks[:0:-1], *ticks]])
    if not over_ground:
        along = (np.arange(len(level_db)) + 0.5) * spacing_m
        for side in (-1, 1):
            altitude = np.where(np.isfinite(waterfall.altitude_m), waterfall.altitude_m, np.nan)
            axes.plot(side * altitude, along, color=RING, linewidth=0.7, alpha=0.8)


def draw_profiles(axes: Axes, profiles: Profiles, bed_m: NDArray[np.float64], depth_m: float) -> None:
    """Draw single-beam echoes in their plane of rotation, the detected ranges, and the true bed.

    The head looks down with its y axis to port; angles are evenly spaced and increasing. bed_m: (n, 2), positions to
    starboard of the head and above it. depth_m: how far the drawing extends below the head.
    """
    together = max(profiles.model.range_bins // SHOWN_BINS, 1)
    bins = profiles.model.range_bins // together
    power = 10.0 ** (profiles.level_db[:, : bins * together].astype(np.float64) / 10.0)
    level_db = (10.0 * np.log10(power.reshape(len(power), bins, together).mean(axis=2))).astype(np.float32)
    edges_m = np.arange(bins + 1) * together * profiles.model.bin_m
    step_rad = profiles.angles_rad[1] - profiles.angles_rad[0]
    turns = np.append(profiles.angles_rad, profiles.angles_rad[-1] + step_rad) - step_rad / 2
    low, high = shown_range(level_db, profiles.noise_db[: bins * together : together])
    label_axes(axes, "Profiling sonar, across the track", "to starboard of the sonar [m]", "above it [m]")
    axes.set_facecolor(NIGHT)
    x, z = -np.outer(np.sin(turns), edges_m), -np.outer(np.cos(turns), edges_m)
    axes.pcolormesh(x, z, level_db, cmap=AMBER, vmin=low, vmax=high, rasterized=True)
    axes.plot(bed_m[:, 0], bed_m[:, 1], color=RING, linewidth=1.0, label="true seabed")
    found_x, found_z = (-profiles.ranges_m * turn(profiles.angles_rad) for turn in (np.sin, np.cos))
    echo = np.isfinite(profiles.ranges_m)
    axes.scatter(found_x[echo], found_z[echo], s=9, color=ACCENT, linewidths=0, label=f"ranges found ({echo.sum()})")
    box = axes.get_position()
    half_m = 0.53 * depth_m * box.width / box.height  # in a square figure, this gives both axes the same scale
    axes.set_xlim(-half_m, half_m)
    axes.set_ylim(-depth_m, 0.06 * depth_m)
    add_legend(axes, 2)


def _round_step(about: float) -> float:
    """Return the smallest value of 1, 2 or 5 times a power of ten that is not less than `about`."""
    scale = 10.0 ** np.floor(np.log10(about))
    return float(next(scale * digit for digit in (1.0, 2.0, 5.0, 10.0) if scale * digit >= about * (1 - 1e-9)))
