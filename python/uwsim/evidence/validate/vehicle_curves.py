"""Figures of decay and turning curves, simulated and published."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from uwsim.base.axes import AXES
from uwsim.evidence.validate.vehicles import UNITS, Curve
from uwsim.figures.style import save_figure


def draw_decays(curves: list[Curve], path: Path) -> None:
    """Draw the speed of each decay along its starting axis against time."""
    decays = [curve for curve in curves if curve.name.startswith("decay")]
    figure, panels = plt.subplots(2, 3, figsize=(11, 6), layout="constrained", dpi=120)
    for panel, curve in zip(panels.flat, decays, strict=True):
        axis = int(np.argmax(np.abs(curve.published.velocities[0])))
        panel.plot(curve.published.times_s, curve.published.velocities[:, axis], lw=4, alpha=0.35, label="published")
        panel.plot(curve.flown.times_s, curve.flown.velocities[:, axis], lw=1.2, label="flown")
        panel.set(title=AXES[axis], xlabel="time [s]", ylabel=f"speed [{UNITS[axis]}]")
        panel.grid(alpha=0.3)
    panels.flat[0].legend()
    figure.suptitle(f"{decays[0].vehicle}: decay from speed")
    save_figure(figure, path)
    plt.close(figure)


def draw_turning(curve: Curve, path: Path) -> None:
    """Draw the path of the turning circle from above."""
    figure, panel = plt.subplots(figsize=(6, 6), layout="constrained", dpi=120)
    panel.plot(*curve.published.positions_m[:, :2].T, lw=4, alpha=0.35, label="published")
    panel.plot(*curve.flown.positions_m[:, :2].T, lw=1.2, label="flown")
    panel.set(title=f"{curve.vehicle}: turning circle", xlabel="x [m]", ylabel="y [m]", aspect="equal")
    panel.grid(alpha=0.3)
    panel.legend()
    save_figure(figure, path)
    plt.close(figure)
