"""Figure of a link trial: delay, delivery and goodput against range and time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from uwsim.figures.style import ACCENT, FAINT_INK, INK, MISSED, label_axes, new_figure, save_figure
from uwsim.link.trial import Trial

CURVE = "#2a6f97"


def draw_link_trial(trial: Trial, path: Path) -> None:
    """Draw a trial as a PNG. Raises OSError."""
    figure = new_figure(11.0, 9.6)
    axes = figure.subplots(3, 2, sharex="col")
    ranges_m = np.array([leg.range_m for leg in trial.legs])
    times_s = np.array([leg.time_s for leg in trial.legs])
    values = {
        "delay": np.array([1e3 * leg.delay_s for leg in trial.legs]),
        "waited": np.array([1e3 * leg.waited_s for leg in trial.legs]),
        "delivery": np.array([100.0 * leg.delivered / leg.sent if leg.sent else np.nan for leg in trial.legs]),
        "goodput": np.array([leg.goodput_bit_s for leg in trial.legs]),
    }
    reach_m = 1.5 * ranges_m.max()
    for column, (x, label) in enumerate(((ranges_m, "range [m]"), (times_s, "simulated time [s]"))):
        top, middle, bottom = axes[:, column]
        label_axes(top, "Delay", "", "delay [ms]")
        label_axes(middle, "Delivery", "", "messages delivered [%]")
        label_axes(bottom, "Goodput", label, "payload delivered [bit/s]")
        style = {"linewidth": 1.0, "marker": ".", "markersize": 4} if column else {"linewidth": 0.0, "marker": "."}
        top.plot(x, values["delay"], color=ACCENT, label="sound, to the first arrival", **style)
        top.plot(x, values["waited"], color=FAINT_INK, label="a message, with its wait", **style)
        middle.plot(x, values["delivery"], color=ACCENT, label="in this run", **style)
        bottom.plot(x, values["goodput"], color=ACCENT, **style)
        top.set_yscale("log")
        middle.set_ylim(-4.0, 104.0)
        bottom.set_ylim(0.0, 1.08 * max(float(values["goodput"].max()), 1.0))
        if column == 0:
            _draw_open_water(trial, top, middle, reach_m)
        else:
            _shade_faults(trial, (top, middle, bottom), float(times_s.max()))
        for each in (top, middle, bottom):
            each.grid(color="#e3e8ec", linewidth=0.6)
    for each in (axes[0, 0], axes[1, 0]):
        each.legend(fontsize=8.5, frameon=False)
    figure.suptitle(
        f"{trial.modem} in {trial.scenario.name}: a vehicle leaves the station and returns",
        x=0.01, ha="left", fontsize=13, fontweight="bold", color=INK,
    )  # fmt: skip
    figure.tight_layout()
    save_figure(figure, path)


def _draw_open_water(trial: Trial, top: Axes, middle: Axes, reach_m: float) -> None:
    """Draw the theoretical values up to the range reach_m."""
    curve = trial.open_water
    near = curve.range_m <= reach_m
    top.plot(
        curve.range_m[near], 1e3 * curve.delay_s[near], color=CURVE, linewidth=1.2, label="path / c, without a bed"
    )
    middle.plot(
        curve.range_m[near],
        100.0 * curve.delivery[near],
        color=CURVE,
        linewidth=1.2,
        label="sonar equation, without a bed",
    )
    top.set_xlim(0.0, reach_m)


def _shade_faults(trial: Trial, axes: tuple[Axes, ...], until_s: float) -> None:
    for fault in trial.faults:
        if fault.from_s < until_s:
            for each in axes:
                each.axvspan(fault.from_s, min(fault.until_s, until_s), color=MISSED, alpha=0.15, linewidth=0.0)
