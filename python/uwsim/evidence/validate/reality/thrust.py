"""Compares the packaged T200 with the manufacturer's bench test, and each sheet with interpolation of the others."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.texts.csv_table import read_csv
from uwsim.evidence.validate.check import Check, at_most
from uwsim.evidence.validate.reality.kinds import AS_MEASURED, PREDICTED
from uwsim.figures.style import save_figure
from uwsim.scenario.spec.actuator import load_thruster

Array = NDArray[np.float64]
Sheet = dict[str, Array]
FILE = "t200/t200_10_14_16_20V.csv"
GROUP = "T200 bench test"
N_PER_KGF = 9.80665
PACKAGED = {"force_kgf": 0.015, "current_a": 0.08, "rpm": 40.0}
LEFT_OUT = {
    14.0: {"force_kgf": 0.05, "current_a": 0.4, "rpm": 60.0},
    16.0: {"force_kgf": 0.05, "current_a": 0.4, "rpm": 60.0},
}
"""Permitted root mean square differences of the packaged sheets, and of a sheet that is left out.

A propeller starts with a jump of 300 rpm, at a command that varies by sheet. Without one sheet, a gap of 6 V remains,
wider than any between the packaged sheets.
"""
UNITS = {"force_kgf": ("thrust", "kgf"), "current_a": ("current", "A"), "rpm": ("speed", "rpm")}


def read_sheets(path: Path) -> dict[float, Sheet]:
    """Return the measured columns, keyed by voltage."""
    columns: dict[float, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    table = read_csv(path)
    volts = table.numbers("voltage_v")
    for name in ("pwm_us", *UNITS):
        for voltage_v, value in zip(volts, table.numbers(name), strict=True):
            columns[float(voltage_v)][name].append(float(value))
    return {volts: {name: np.array(values) for name, values in sheet.items()} for volts, sheet in columns.items()}


def without(volts: float, sheets: dict[float, Sheet]) -> _core.ThrusterSheets:
    """Return a thruster from all sheets except one."""
    return _core.ThrusterSheets(
        [
            _core.ThrusterSheet(v, (s["pwm_us"] - 1500) / 400, s["force_kgf"] * N_PER_KGF, s["current_a"], s["rpm"])
            for v, s in sorted(sheets.items())
            if v != volts
        ]
    )


def misses(simulated: _core.ThrusterSheets, volts: float, measured: Sheet) -> dict[str, float]:
    """Return root mean square differences from a measured sheet, by column."""
    got = _curves(simulated, volts, measured["pwm_us"])
    return {name: float(np.sqrt(np.mean((got[name] - measured[name]) ** 2))) for name in UNITS}


def checks(data: Path, out: Path | None) -> list[Check]:
    """Return the checks; draw thrust and current by pulse width into the folder `out`."""
    sheets = read_sheets(data / FILE)
    packaged = load_thruster("t200_16v").performance()
    found = []
    for volts, measured in sorted(sheets.items()):
        for name, miss in misses(packaged, volts, measured).items():
            found.append(_check(AS_MEASURED, f"{volts:g} V, packaged", name, PACKAGED[name], miss))
    for volts, limits in LEFT_OUT.items():
        others = " and ".join(f"{other:g}" for other in _neighbours(volts, sheets))
        for name, miss in misses(without(volts, sheets), volts, sheets[volts]).items():
            found.append(_check(PREDICTED, f"{volts:g} V from {others} V", name, limits[name], miss))
    if out is not None:
        _draw(sheets, packaged, out / "reality_thrust.png")
    return found


def _check(kind: str, label: str, name: str, limit: float, miss: float) -> Check:
    quantity, unit = UNITS[name]
    return at_most(f"{kind}: {GROUP}", f"{label}: rms {quantity}", limit, miss, unit)


def _neighbours(volts: float, sheets: dict[float, Sheet]) -> tuple[float, float]:
    return max(v for v in sheets if v < volts), min(v for v in sheets if v > volts)


def _curves(simulated: _core.ThrusterSheets, volts: float, pwm_us: Array) -> Sheet:
    rows = np.array([simulated.at((pwm - 1500.0) / 400.0, volts) for pwm in pwm_us]).T
    return {"force_kgf": rows[0] / N_PER_KGF, "current_a": rows[1], "rpm": rows[2]}


def _draw(sheets: dict[float, Sheet], packaged: _core.ThrusterSheets, path: Path) -> None:
    figure, panels = plt.subplots(1, 3, figsize=(13, 4), layout="constrained", dpi=120)
    for colour, (volts, measured) in zip(("C0", "C1", "C2", "C3"), sorted(sheets.items()), strict=True):
        got = _curves(packaged, volts, measured["pwm_us"])
        for panel, (name, (quantity, unit)) in zip(panels, UNITS.items(), strict=True):
            panel.plot(measured["pwm_us"][::8], measured[name][::8], "o", ms=4, mfc="none", c=colour)
            panel.plot(measured["pwm_us"], got[name], "-", lw=1, c=colour, label=f"{volts:g} V")
            panel.set(xlabel="pulse width [us]", title=f"{quantity} [{unit}]")
    for volts, colour in ((12.0, "0.6"), (18.0, "0.3")):
        got = _curves(packaged, volts, sheets[10.0]["pwm_us"])
        for panel, name in zip(panels, UNITS, strict=True):
            panel.plot(sheets[10.0]["pwm_us"], got[name], ":", lw=1, c=colour, label=f"{volts:g} V, interpolated")
    panels[0].legend(fontsize=8)
    figure.suptitle("T200: measured (circles) and simulated (lines)")
    save_figure(figure, path)
    plt.close(figure)
