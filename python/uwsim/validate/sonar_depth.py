"""The maximum depth of an EM 2040: the manufacturer's table, and the sonar equation with constants fitted to it.

At nadir, SL + PG + DI + BS - NL - DT = 40 log R + 2 alpha R - 10 log A(R): a constant of the instrument equals the
losses along the path. The area A that contributes to one range cell (_core.nadir_area_m2) grows as R^2 while relief is
lower than a range cell and as R beyond, from about 30 m of depth on: 30 log R for nearly the whole table.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from uwsim import _core
from uwsim.scenario.build.multibeam import acoustic_spec, bottom_material
from uwsim.scenario.spec.material import ROCK
from uwsim.scenario.spec.sonar import load_sonar

ARRAYS = ("em2040-04", "em2040-07")
FREQUENCIES_KHZ = (200, 300, 400, 600, 700)
TEMPERATURE_DEG_C = 4.0
ACIDITY_PH = 8.0
DEEPEST_M = 4000.0


@dataclass(frozen=True)
class ColdWater:
    """Assumed water of the table."""

    text: str
    salinity_psu: float

    @property
    def sound_speed_m_s(self) -> float:
        """The speed of sound at the head, which is at the surface."""
        return self.core_water().sound_speed_m_s(0.0)

    def core_water(self) -> _core.Water:
        """Return the core's water."""
        water = _core.Water()
        water.surface_temperature_deg_c = water.bottom_temperature_deg_c = TEMPERATURE_DEG_C
        water.salinity_psu = self.salinity_psu
        water.bottom_depth_m = DEEPEST_M
        return water


WATERS = {
    "ocean": ColdWater("ocean, 4 deg C, 35 psu, pH 8", 35.0),
    "fresh": ColdWater("fresh, 4 deg C, 0 psu", 0.0),
}


@dataclass(frozen=True)
class Cell:
    """A cell of the manufacturer's table."""

    array: str
    frequency_khz: int
    water: str

    def depth_m(self, constant_db: float) -> float:
        """Return the maximum depth of an instrument with this constant."""
        return float(brentq(lambda depth_m: self.loss_db(depth_m) - constant_db, 0.5, DEEPEST_M, xtol=1e-6))

    def loss_db(self, depth_m: float) -> float:
        """Return 40 log R + 2 alpha R - 10 log A, with the mean alpha over depth."""
        figures, water = acoustics(self.array, self.frequency_khz).figures, WATERS[self.water]
        area_m2 = _core.nadir_area_m2(figures, bottom_material(ROCK), depth_m, water.sound_speed_m_s)
        absorbed_db = 2e-3 * self.mean_absorption_db_km(depth_m) * depth_m
        return 40 * math.log10(depth_m) + absorbed_db - 10 * math.log10(area_m2)

    def mean_absorption_db_km(self, depth_m: float) -> float:
        """Return the mean absorption (Francois and Garrison) by Gauss-Legendre quadrature, smooth in depth."""
        places, weights = np.polynomial.legendre.leggauss(4)
        salinity_psu = WATERS[self.water].salinity_psu
        hertz = 1e3 * self.frequency_khz
        return sum(
            0.5
            * weight
            * _core.absorption_db_km(hertz, TEMPERATURE_DEG_C, salinity_psu, 0.5 * (1 + place) * depth_m, ACIDITY_PH)
            for place, weight in zip(places, weights, strict=True)
        )

    def stated_depth_m(self) -> float:
        """Return the maximum depth by the figures of the model's file."""
        return self.depth_m(stated_db(self.array, self.frequency_khz))


# The seed paper's Fig. 8: rock, BS = -30 dB, NL = 45 dB, PR enabled.
_FIG_8 = {
    ("em2040-04", "ocean"): (635, 480, 315, 95, 55),
    ("em2040-04", "fresh"): (1360, 740, 430, 115, 60),
    ("em2040-07", "ocean"): (600, 465, 300, 85, 50),
    ("em2040-07", "fresh"): (1300, 700, 375, 105, 55),
}
TABLE_M = {
    Cell(array, khz, water): float(depth_m)
    for (array, water), depths_m in _FIG_8.items()
    for khz, depth_m in zip(FREQUENCIES_KHZ, depths_m, strict=True)
}


@lru_cache(maxsize=32)
def acoustics(array: str, frequency_khz: int) -> _core.AcousticSpec:
    """Return the figures of the packaged model."""
    return acoustic_spec(load_sonar(array), frequency_khz)


def stated_db(array: str, frequency_khz: int) -> float:
    """Return SL + PG + DI + BS - NL - DT of the model's file and of rock."""
    figures = acoustics(array, frequency_khz).figures
    return figures.figure_db + ROCK.strength_db - figures.detection_threshold_db


@dataclass(frozen=True)
class Fit:
    """Six constants: one for each frequency of the first array, and the difference of the second array."""

    constants_db: dict[int, float]
    array_difference_db: float

    def depth_m(self, cell: Cell) -> float:
        """Return the maximum depth by the sonar equation."""
        less_db = 0.0 if cell.array == ARRAYS[0] else self.array_difference_db
        return cell.depth_m(self.constants_db[cell.frequency_khz] - less_db)


def fit_table() -> Fit:
    """Return the constants that minimise the largest relative error."""

    def fit_frequency(khz: int, difference_db: float) -> tuple[float, float]:
        """Return the constant and its largest relative error, where two cells have equal errors of opposite sign."""
        cells = [cell for cell in TABLE_M if cell.frequency_khz == khz]

        def largest_error(constant_db: float) -> float:
            fit = Fit({khz: constant_db}, difference_db)
            return max(abs(fit.depth_m(cell) / TABLE_M[cell] - 1) for cell in cells)

        required = [cell.loss_db(TABLE_M[cell]) + (0.0 if cell.array == ARRAYS[0] else difference_db) for cell in cells]
        found = minimize_scalar(
            largest_error, bounds=(min(required), max(required)), method="bounded", options={"xatol": 1e-3}
        )
        return float(found.x), float(found.fun)

    def largest_error(difference_db: float) -> float:
        return max(fit_frequency(khz, difference_db)[1] for khz in FREQUENCIES_KHZ)

    difference = minimize_scalar(largest_error, bounds=(0.0, 12.0), method="bounded", options={"xatol": 1e-2})
    difference_db = float(difference.x)
    return Fit({khz: fit_frequency(khz, difference_db)[0] for khz in FREQUENCIES_KHZ}, difference_db)
