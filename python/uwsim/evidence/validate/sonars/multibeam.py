"""The sonar suite: compares depths and coverages with the manufacturer's table, and physics mode with the formula.

Assumed water: 4 deg C at all depths; ocean with 35 psu and pH 8.0, fresh water with 0 psu. The bed is flat rock. Each
instrument has one set of values per frequency, assumed or chosen to agree with the table as a whole, for one receiver
and two. The gain of the second receiver follows from its tilt alone. Refraction is checked against a closed form.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby

import numpy as np

from uwsim.evidence.validate.check import Check, Curve, relative
from uwsim.evidence.validate.sonars.instrument import half_detected_m, half_detected_swath_m
from uwsim.evidence.validate.sonars.refraction import smile_checks
from uwsim.evidence.validate.sonars.table import COVERAGE_M, DEPTH_M, DUAL_COVERAGE_M, WATERS, Cell

TABLE_TOLERANCE = 0.1
# Of the factor by which the second receiver widens the coverage. At 300 kHz the table has 1.13 to 1.15, twice the gain
# at 200 and at 400 kHz, for which no cause is known; the simulated factor is about 1.06 at all three.
GAIN_TOLERANCE = {200: 0.03, 300: 0.1, 400: 0.03}
INSTRUMENT_TOLERANCE = 0.05
SWATH_TOLERANCE = 0.08  # 0.2 dB at 700 kHz, at which vertical and outer beams differ by 1 dB
BEYOND = 1.15  # factor on the depth of the widest swath, beyond which weak outer beams limit the swath, not the fan
TOWARDS_DEEPEST = 1 / 3  # fraction of the way from there to the maximum depth, near which 0.06 dB is 8 % of the swath


def run() -> list[Check]:
    """Return the checks of the suite, with the depths and coverages over frequency."""
    simulated = {cell: half_detected_m(cell) for cell in DEPTH_M}
    return [*table_checks(), *instrument_checks(simulated), *swath_checks(), *smile_checks()]


def table_checks() -> list[Check]:
    """Check each depth and coverage in the manufacturer's table against the values in the instrument files.

    Also check by which factor the second receiver widens the coverage.
    """
    depths = [in_table("depth", cell, table_m, cell.depth_m()) for cell, table_m in DEPTH_M.items()]
    found_m = {cell: cell.coverage().width_m for cell in COVERAGE_M}
    coverages = [
        in_table(f"coverage, {cell.receivers} RX", cell, table_m, found_m[cell]) for cell, table_m in COVERAGE_M.items()
    ]
    singles = {cell: replace(cell, receivers=1) for cell in DUAL_COVERAGE_M}
    gains = [
        relative(
            f"{cell.array} coverage, 2 RX / 1 RX, {cell.water}", f"{cell.frequency_khz} kHz",
            COVERAGE_M[cell] / COVERAGE_M[one], found_m[cell] / found_m[one], GAIN_TOLERANCE[cell.frequency_khz],
        )
        for cell, one in singles.items()
    ]  # fmt: skip
    return [*_with_curves(depths), *_with_curves(coverages), *gains]


def _with_curves(checks: list[Check]) -> Iterator[Check]:
    """Give the first check of each group, of one column over frequency, the curve of all."""
    for group, each in groupby(checks, key=lambda check: check.group):
        column = [first, *others] = list(each)
        khz = np.array([float(check.name.removesuffix(" kHz")) for check in column])
        lines = {name: np.array([getattr(check, name) for check in column]) for name in ("expected", "got")}
        yield replace(first, curve=Curve(khz, lines, "frequency [kHz]", "m", group))
        yield from others


def instrument_checks(simulated: dict[Cell, float]) -> list[Check]:
    """Check the depth at which physics mode detects half of the beams against the formula with the same values."""
    found = []
    for cell, depth_m in simulated.items():
        group, name = f"{cell.array} depth simulated, {cell.water}", f"{cell.frequency_khz} kHz"
        found.append(relative(group, name, cell.depth_m(), depth_m, INSTRUMENT_TOLERANCE, "m"))
    return found


def swath_checks() -> list[Check]:
    """Check the swath where physics mode detects half of the beams against the formula, at one depth per cell."""
    checks = []
    for cell in (cell for cell in COVERAGE_M if cell.array == "em2040-04" and cell.water == "ocean"):
        widest_m = cell.coverage().depth_m
        depth_m = min(BEYOND * widest_m, widest_m + TOWARDS_DEEPEST * (cell.depth_m() - widest_m))
        name = f"{cell.frequency_khz} kHz, {depth_m:.0f} m deep"
        simulated_m = half_detected_swath_m(cell, depth_m)
        group = f"{cell.array} swath simulated, {cell.receivers} RX, {cell.water}"
        checks.append(relative(group, name, cell.swath_m(depth_m), simulated_m, SWATH_TOLERANCE, "m"))
    return checks


def in_table(column: str, cell: Cell, table_m: float, got_m: float) -> Check:
    """Compare a value with that of the manufacturer's table."""
    group = f"{cell.array} {column}, {WATERS[cell.water].text}"
    return relative(group, f"{cell.frequency_khz} kHz", table_m, got_m, TABLE_TOLERANCE, "m")
