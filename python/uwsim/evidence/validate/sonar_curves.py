"""Figures of the sonar suite: depths over frequency, detection rates over depth, and the refraction smile."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from uwsim import _core
from uwsim.evidence.validate.refraction import BED_M, GRADIENT_1_S, bent_ping
from uwsim.evidence.validate.sonar_instrument import detection_rate
from uwsim.evidence.validate.sonar_table import (
    ARRAYS,
    DEPTH_M,
    DUAL_COVERAGE_M,
    FREQUENCIES_KHZ,
    SINGLE_COVERAGE_M,
    WATERS,
    Cell,
)
from uwsim.figures.style import save_figure
from uwsim.instruments.sonars.soundings import sound_points


def draw_table(simulated: dict[Cell, float], path: Path) -> None:
    """Draw depth and coverage against frequency, from the table and the formula, and the simulated depth."""
    figure, panels = plt.subplots(2, 2, figsize=(11, 9), layout="constrained", dpi=120, sharex=True, sharey="row")
    for column, array in enumerate(ARRAYS):
        for colour, water in zip(("tab:blue", "tab:green"), WATERS, strict=True):
            for row, table_m, mark, line, name in (
                (0, DEPTH_M, "o", "-", water),
                (1, SINGLE_COVERAGE_M, "o", "-", f"{water}, one receiver"),
                (1, DUAL_COVERAGE_M, "s", "--", f"{water}, two receivers"),
            ):
                cells = [cell for cell in table_m if (cell.array, cell.water) == (array, water)]
                khz = [cell.frequency_khz for cell in cells]
                formula_m = [cell.depth_m() if row == 0 else cell.coverage().width_m for cell in cells]
                panel, known_m = panels[row, column], [table_m[cell] for cell in cells]
                panel.plot(khz, known_m, mark, ms=11, mfc="none", c=colour, label=f"table, {name}")
                panel.plot(khz, formula_m, line, c=colour, label=f"formula, {name}")
            simulated_m = [simulated[Cell(array, khz, water)] for khz in FREQUENCIES_KHZ]
            panels[0, column].plot(FREQUENCIES_KHZ, simulated_m, "x", c=colour, label=f"simulated, {water}")
        panels[0, column].set(title=array, yscale="log")
        panels[1, column].set(xlabel="frequency [kHz]", yscale="log")
    panels[0, 0].set_ylabel("maximum depth [m]")
    panels[1, 0].set_ylabel("widest swath [m]")
    for panel in panels.flat:
        panel.grid(alpha=0.3, which="both")
    for panel in panels[:, 1]:
        panel.legend(fontsize=8)
    figure.suptitle("Over flat rock, cold water, values as packaged")
    save_figure(figure, path)
    plt.close(figure)


def draw_detections(path: Path) -> None:
    """Draw the packaged sonars' detection rate straight down against depth."""
    figure, panel = plt.subplots(figsize=(8, 5), layout="constrained", dpi=120)
    for khz in FREQUENCIES_KHZ:
        cell = Cell(ARRAYS[0], khz, "ocean")
        about_m = cell.depth_m()
        depths_m = about_m * np.linspace(0.5, 1.3, 17)
        panel.plot(depths_m, detection_rate(cell, depths_m.tolist()), label=f"{khz} kHz")
        panel.axvline(about_m, c="k", lw=0.6, ls=":")
    panel.set(xlabel="depth [m]", ylabel="detection rate", xscale="log", title=f"{ARRAYS[0]}, cold ocean, flat rock")
    panel.grid(alpha=0.3, which="both")
    panel.legend()
    save_figure(figure, path)
    plt.close(figure)


def draw_smile(path: Path) -> None:
    """Draw a flat bed under a sound-speed gradient, sounded with the true profile and with a constant speed."""
    ping, sonar = bent_ping()
    even = _core.SoundSpeedProfile.even(sonar.profile.at(0.0))
    figure, panel = plt.subplots(figsize=(8, 4), layout="constrained", dpi=120)
    panel.axhline(-BED_M, c="k", lw=0.8, label="the bed")
    for name, profile in (("sounded with the true profile", sonar.profile), ("sounded with a constant speed", even)):
        points = sound_points(ping, profile)
        panel.plot(points[:, 1], points[:, 2], ".", ms=4, label=name)
    panel.set(
        xlabel="across [m]", ylabel="z [m]", title=f"A flat bed, sound speed falling by {-GRADIENT_1_S:g} m/s per metre"
    )
    panel.grid(alpha=0.3)
    panel.legend()
    save_figure(figure, path)
    plt.close(figure)
