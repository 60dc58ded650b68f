"""Compares the packaged T200 with the manufacturer's bench test, and each sheet with interpolation of the others."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.texts.csv_table import read_csv
from uwsim.evidence.validate.check import Check, Curve, at_most
from uwsim.evidence.validate.reality.kinds import AS_MEASURED, PREDICTED
from uwsim.scenario.spec.actuator import load_thruster

Sheet = dict[str, Floats]
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


def checks(data: Path) -> list[Check]:
    """Return the checks."""
    sheets = read_sheets(data / FILE)
    packaged = load_thruster("t200_16v").performance()
    found: list[Check] = []
    for volts, measured in sorted(sheets.items()):
        found += _checks(AS_MEASURED, f"{volts:g} V, packaged", packaged, volts, measured, PACKAGED)
    for volts, limits in LEFT_OUT.items():
        others = " and ".join(f"{other:g}" for other in _neighbours(volts, sheets))
        others_only = without(volts, sheets)
        found += _checks(PREDICTED, f"{volts:g} V from {others} V", others_only, volts, sheets[volts], limits)
    return found


def _checks(
    kind: str, label: str, simulated: _core.ThrusterSheets, volts: float, measured: Sheet, limits: dict[str, float]
) -> Iterator[Check]:
    got = _curves(simulated, volts, measured["pwm_us"])
    for name, miss in misses(simulated, volts, measured).items():
        quantity, unit = UNITS[name]
        check = at_most(f"{kind}: {GROUP}", f"{label}: rms {quantity}", limits[name], miss, unit)
        lines = {"measured": measured[name], "simulated": got[name]}
        yield replace(check, curve=Curve(measured["pwm_us"], lines, "pulse width [us]", unit, f"{label}: {quantity}"))


def _neighbours(volts: float, sheets: dict[float, Sheet]) -> tuple[float, float]:
    return max(v for v in sheets if v < volts), min(v for v in sheets if v > volts)


def _curves(simulated: _core.ThrusterSheets, volts: float, pwm_us: Floats) -> Sheet:
    rows = np.array([simulated.at((pwm - 1500.0) / 400.0, volts) for pwm in pwm_us]).T
    return {"force_kgf": rows[0] / N_PER_KGF, "current_a": rows[1], "rpm": rows[2]}
