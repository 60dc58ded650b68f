"""The report of an identification: values with intervals, undetermined combinations, and residuals."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.base.axes import AXES
from uwsim.evidence.identification.calibrated_file import write_calibrated
from uwsim.evidence.identification.solution import Identified

COLUMNS = (
    *(f"position {axis} [m]" for axis in "xyz"),
    *(f"attitude about {axis} [rad]" for axis in "xyz"),
    *(f"{axis} [m/s]" for axis in AXES[:3]),
    *(f"{axis} [rad/s]" for axis in AXES[3:]),
)
VEHICLE, REPORT, FIGURE = "vehicle.yaml", "report.md", "residuals.png"


def write_report(found: Identified, log: str, out: Path) -> list[Path]:
    """Write the vehicle, the report and the figure of the residuals into a folder, and return their paths."""
    out.mkdir(parents=True, exist_ok=True)
    write_calibrated(found, log, out / VEHICLE)
    write_atomically(out / REPORT, _page(found, log).encode())
    _draw(found, out / FIGURE)
    return [out / VEHICLE, out / REPORT, out / FIGURE]


def table(found: Identified) -> list[tuple[str, ...]]:
    """Return name, initial value, value, interval ends and unit of each quantity, and "no" if it is undetermined."""
    return [
        (
            v.name,
            f"{v.before:.4g}",
            f"{v.value:.4g}",
            f"{v.low:.4g}",
            f"{v.high:.4g}",
            v.unit,
            "" if v.is_determined else "no",
        )
        for v in found.values.values()
    ]


def undetermined_lines(found: Identified) -> list[str]:
    """Return one line for each combination that the log does not determine."""
    lines = []
    for left, parts in found.undetermined:
        text = " ".join(f"{'+' if part > 0 else '-'} {abs(part):.2f} {name}" for name, part in parts.items())
        lines.append(f"{text.removeprefix('+ ')}: {left:.0%} of the spread assumed before is left")
    return lines


def _page(found: Identified, log: str) -> str:
    rows = ["| " + " | ".join(row) + " |" for row in table(found)]
    undetermined = [f"- {line}" for line in undetermined_lines(found)] or [
        "Nothing: every combination is determined by the log."
    ]
    residuals = [
        f"| {name} | {noise:.3g} | {correlation:.2f} |"
        for name, noise, correlation, column in zip(
            COLUMNS, found.noise, found.correlation, found.residuals.T, strict=True
        )
        if np.isfinite(column).any()
    ]
    return "\n".join(
        [
            f"# Identification from {log}",
            "",
            "| quantity | before | identified | 95 % from | to | unit | determined by the log |",
            "|---|---|---|---|---|---|---|",
            *rows,
            "",
            "A quantity that the log does not determine keeps what was assumed before. Coefficients that are zero in"
            " the vehicle's file are held. All values depend on:",
            "",
            *(f"- {line}" for line in found.premises),
            "",
            "## What the log does not determine",
            "",
            "Combinations, in standard deviations of the assumptions, of which the log determines less than these do:",
            "",
            *undetermined,
            "",
            "## Residuals",
            "",
            "| output | rms | correlation between successive residuals |",
            "|---|---|---|",
            *residuals,
            "",
            "Intervals assume that the model is right. Correlated residuals suggest that it is not; the intervals are"
            " widened for them.",
            "",
            f"![Residuals]({FIGURE})",
            "",
        ]
    )


def _draw(found: Identified, path: Path) -> None:
    import matplotlib.pyplot as plt

    from uwsim.figures.style import save_figure

    figure, panels = plt.subplots(4, 1, figsize=(9, 9), layout="constrained", dpi=120, sharex=True)
    for k, (panel, name) in enumerate(
        zip(panels, ("position [m]", "attitude [rad]", "velocity [m/s]", "rate [rad/s]"), strict=True)
    ):
        for axis in range(3):
            panel.plot(found.times_s, found.residuals[:, 3 * k + axis], lw=0.7, label="xyz"[axis])
        panel.set_ylabel(name)
    panels[0].set_title("simulated minus measured")
    panels[0].legend(ncols=3)
    panels[-1].set_xlabel("time [s]")
    save_figure(figure, path)
    plt.close(figure)
