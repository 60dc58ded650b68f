"""Compares two-way times traced through the sound-speed profiles of two EM 302 surveys with the recorded times.

NOAA Ship Okeanos Explorer, 2018 and 2016. The checks are those of the sound suite; the figure shows the remaining
differences.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.reality.kinds import PREDICTED
from uwsim.evidence.validate.sound import SURVEYS, survey_check_of, survey_left_s
from uwsim.figures.style import save_figure

FILE = f"gsf/{next(iter(SURVEYS))}"


def checks(data: Path, out: Path | None) -> list[Check]:
    """Return the checks; draw the remaining differences into the folder `out`."""
    paths = [path for name in SURVEYS if (path := data / "gsf" / name).is_file()]
    for name in SURVEYS:
        if data / "gsf" / name not in paths:
            warnings.warn(f"validate reality: no {data / 'gsf' / name}", stacklevel=2)
    left_s = {path: survey_left_s(path) for path in paths}
    if out is not None:
        figure, panel = plt.subplots(figsize=(8, 4), layout="constrained", dpi=120)
        for path, values in left_s.items():
            panel.hist(1e3 * values, np.linspace(-2, 2, 81).tolist(), density=True, histtype="step", label=path.stem)
        panel.set(xlabel="recorded minus simulated two-way time, one offset per ping [ms]", ylabel="density")
        panel.legend(fontsize=8)
        save_figure(figure, out / "reality_soundings.png")
        plt.close(figure)
    found = [survey_check_of(path, values, SURVEYS[path.name]) for path, values in left_s.items()]
    return [replace(check, group=f"{PREDICTED}: {check.group}") for check in found]
