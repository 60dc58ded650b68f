"""Figures of step responses: one panel per step, with rise time, overshoot, settling time and steady-state error."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

import matplotlib.pyplot as plt

from uwsim.evidence.validate.step_responses import SETTLED, StepResponse
from uwsim.figures.style import save_figure

COLUMNS = 3


def draw_steps(responses: list[StepResponse], path: Path, before: Sequence[StepResponse] = ()) -> None:
    """Draw all of a vehicle's step responses. before: its responses to the same steps with other gains, if any."""
    rows = -(-len(responses) // COLUMNS)
    size = (4.0 * COLUMNS, 2.6 * rows)
    figure, panels = plt.subplots(rows, COLUMNS, figsize=size, layout="constrained", dpi=120, squeeze=False)
    for panel in panels.flat[len(responses) :]:
        panel.set_axis_off()
    for panel, response, other in zip_longest(panels.flat[: len(responses)], responses, before):
        step = response.step
        panel.axhspan(step.size * (1 - SETTLED), step.size * (1 + SETTLED), color="0.85", label=f"within {SETTLED:.0%}")
        panel.axhline(step.size, color="0.4", lw=0.8)
        if other is not None:
            panel.plot(other.times_s, step.size * other.values, lw=1.2, ls="--", color="0.4", label="before")
        panel.plot(response.times_s, step.size * response.values, lw=1.6, label=None if other is None else "after")
        panel.set(title=step.name, xlabel="time [s]", ylabel=f"[{step.unit}]")
        panel.grid(alpha=0.3)
        figures = (
            f"rise {response.rise_s:.1f} s\novershoot {response.overshoot:.1%}\n"
            f"settling {response.settling_s:.1f} s\nsteady error {response.steady_error:.2%}"
        )
        panel.text(0.97, 0.08, figures, transform=panel.transAxes, ha="right", va="bottom", fontsize=8)
    if before:
        figure.legend(*panels[0, 0].get_legend_handles_labels(), fontsize=8, loc="outside upper right", ncols=3)
    figure.suptitle(f"{responses[0].vehicle}: step responses")
    save_figure(figure, path)
    plt.close(figure)
