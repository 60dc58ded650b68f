"""Figures of the sonar suite: depths over frequency, detection rates over depth, and the smile of refraction."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from uwsim import _core
from uwsim.figures.style import save_figure
from uwsim.sonars.soundings import sound_points
from uwsim.validate.refraction import BED_M, GRADIENT_1_S, bent_ping
from uwsim.validate.sonar_depth import ARRAYS, FREQUENCIES_KHZ, TABLE_M, WATERS, Cell, Fit
from uwsim.validate.sonar_instrument import detection_rate


def draw_depths(fit: Fit, simulated: dict[Cell, float], path: Path) -> None:
    """Draw the maximum depth over frequency: the manufacturer's, the fitted formula's and the simulated one."""
    figure, panels = plt.subplots(1, 2, figsize=(11, 5), layout="constrained", dpi=120, sharey=True)
    for panel, array in zip(panels, ARRAYS, strict=True):
        for colour, water in zip(("tab:blue", "tab:green"), WATERS, strict=True):
            cells = [Cell(array, khz, water) for khz in FREQUENCIES_KHZ]
            panel.plot(
                FREQUENCIES_KHZ, [TABLE_M[c] for c in cells], "o", ms=11, mfc="none", c=colour, label=f"table, {water}"
            )
            panel.plot(
                FREQUENCIES_KHZ, [fit.depth_m(c) for c in cells], "-", c=colour, label=f"formula, fitted, {water}"
            )
            panel.plot(
                FREQUENCIES_KHZ, [simulated[c] for c in cells], "x", c=colour, label=f"simulated, as packaged, {water}"
            )
        panel.set(title=array, xlabel="frequency [kHz]", yscale="log")
        panel.grid(alpha=0.3, which="both")
    panels[0].set_ylabel("greatest depth [m]")
    panels[1].legend(fontsize=8)
    figure.suptitle("Greatest depth over flat rock, straight below, cold water")
    save_figure(figure, path)
    plt.close(figure)


def draw_detections(path: Path) -> None:
    """Draw the detection rate of the packaged sonars straight below, over depth."""
    figure, panel = plt.subplots(figsize=(8, 5), layout="constrained", dpi=120)
    for khz in FREQUENCIES_KHZ:
        cell = Cell(ARRAYS[0], khz, "ocean")
        about_m = cell.stated_depth_m()
        depths_m = about_m * np.linspace(0.5, 1.3, 33)
        panel.plot(depths_m, detection_rate(cell, depths_m.tolist()), label=f"{khz} kHz")
        panel.axvline(about_m, c="k", lw=0.6, ls=":")
    panel.set(xlabel="depth [m]", ylabel="detection rate", xscale="log", title=f"{ARRAYS[0]}, cold ocean, flat rock")
    panel.grid(alpha=0.3, which="both")
    panel.legend()
    save_figure(figure, path)
    plt.close(figure)


def draw_smile(path: Path) -> None:
    """Draw a flat bed under a gradient, sounded with the true profile and with a constant speed."""
    ping, sonar = bent_ping()
    even = _core.SoundSpeedProfile.even(sonar.profile.at(0.0))
    figure, panel = plt.subplots(figsize=(8, 4), layout="constrained", dpi=120)
    panel.axhline(-BED_M, c="k", lw=0.8, label="the bed")
    for name, profile in (
        ("sounded with the true profile", sonar.profile),
        ("sounded with a constant speed", even),
    ):
        points = sound_points(ping, profile)
        panel.plot(points[:, 1], points[:, 2], ".", ms=4, label=name)
    panel.set(
        xlabel="across [m]", ylabel="z [m]", title=f"A flat bed, sound speed falling by {-GRADIENT_1_S:g} m/s per metre"
    )
    panel.grid(alpha=0.3)
    panel.legend()
    save_figure(figure, path)
    plt.close(figure)
