"""The sonar suite: maximum depths against the manufacturer's table, physics mode against its formula, refraction.

Assumed water: 4 deg C at all depths; ocean with 35 psu and pH 8.0, fresh water with 0 psu. Nadir, flat rock.
"""

from __future__ import annotations

from pathlib import Path

from uwsim.validate.check import Check, relative, within
from uwsim.validate.refraction import refraction_checks
from uwsim.validate.sonar_curves import draw_depths, draw_detections, draw_smile
from uwsim.validate.sonar_depth import ARRAYS, FREQUENCIES_KHZ, TABLE_M, WATERS, Cell, Fit, fit_table, stated_db
from uwsim.validate.sonar_instrument import half_detected_m

TABLE_TOLERANCE = 0.06
CONSTANT_TOLERANCE_DB = 3.0
INSTRUMENT_TOLERANCE = 0.05


def run(out: Path | None = None) -> list[Check]:
    """Return all checks; draw depths, detection rates and the smile of refraction into the folder `out`."""
    fit = fit_table()
    simulated = {cell: half_detected_m(cell) for cell in TABLE_M}
    if out is not None:
        draw_depths(fit, simulated, out / "sonar_depths.png")
        draw_detections(out / "sonar_detections.png")
        draw_smile(out / "sonar_smile.png")
    return [*table_checks(fit), *constant_checks(fit), *instrument_checks(simulated), *refraction_checks()]


def table_checks(fit: Fit) -> list[Check]:
    """Check each of the manufacturer's 20 depths against the sonar equation with fitted constants."""
    return [
        relative(
            f"{cell.array} {WATERS[cell.water].text}",
            f"{cell.frequency_khz} kHz",
            table_m,
            fit.depth_m(cell),
            TABLE_TOLERANCE,
            "m",
        )
        for cell, table_m in TABLE_M.items()
    ]


def constant_checks(fit: Fit) -> list[Check]:
    """Check each fitted constant against SL + PG + DI + BS - NL - DT of the model's file; values and errors in dB."""
    first, second = ARRAYS
    group = "fitted constants (expected: SL + PG + DI + BS - NL - DT)"
    checks = [
        within(
            group, f"{first} {khz} kHz", stated_db(first, khz), fit.constants_db[khz], 1.0, CONSTANT_TOLERANCE_DB, "dB"
        )
        for khz in FREQUENCIES_KHZ
    ]
    differences = [stated_db(first, khz) - stated_db(second, khz) for khz in FREQUENCIES_KHZ]
    stated = sum(differences) / len(differences)
    name = f"{first} less {second}"
    return [*checks, within(group, name, stated, fit.array_difference_db, 1.0, CONSTANT_TOLERANCE_DB, "dB")]


def instrument_checks(simulated: dict[Cell, float]) -> list[Check]:
    """Check the depth at which physics mode detects half of the beams against the formula with the same figures."""
    return [
        relative(
            f"{cell.array} simulated, {cell.water}",
            f"{cell.frequency_khz} kHz",
            cell.stated_depth_m(),
            depth_m,
            INSTRUMENT_TOLERANCE,
            "m",
        )
        for cell, depth_m in simulated.items()
    ]
