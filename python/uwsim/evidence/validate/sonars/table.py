"""The manufacturer's table for an EM 2040, and the sonar equation's values for the parameters in the instrument file.

Over flat rock, a beam is detected while SL + PG + DI - NL minus the losses along its path exceeds the detector's
threshold (_core.bottom_echo). The maximum depth is that of the vertical beam; the coverage is the widest swath at any
depth. The table is Fig. 8 of the paper: 20 depths, and 32 coverages, with one and, at 200 to 400 kHz, also with two
receivers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from uwsim import _core
from uwsim.scenario.build.multibeam import acoustic_spec, bottom_material, multibeam_model
from uwsim.scenario.spec.material import ROCK
from uwsim.scenario.spec.sonar import load_sonar

ARRAYS = ("em2040-04", "em2040-07")
FREQUENCIES_KHZ = (200, 300, 400, 600, 700)
TEMPERATURE_DEG_C = 4.0
ACIDITY_PH = 8.0
DEEPEST_M = 4000.0


@dataclass(frozen=True)
class ColdWater:
    """Water assumed for the table."""

    text: str
    salinity_psu: float

    @cached_property
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


WATERS = {"ocean": ColdWater("ocean, 4 deg C, 35 psu, pH 8", 35.0), "fresh": ColdWater("fresh, 4 deg C, 0 psu", 0.0)}


@dataclass(frozen=True)
class Swath:
    """The widest swath of an instrument: its width and depth."""

    width_m: float
    depth_m: float


@dataclass(frozen=True)
class Cell:
    """A table cell: an instrument at one frequency in one kind of water, with one or two receivers."""

    array: str
    frequency_khz: int
    water: str
    receivers: Literal[1, 2] = 1

    @property
    def fan(self) -> _core.MultibeamModel:
        """The fan of the packaged instrument."""
        return _packaged_fan(self.array, self.frequency_khz, self.receivers)

    @property
    def half_fan_rad(self) -> float:
        """The angle of the outermost beam from straight down."""
        return 0.5 * self.fan.field_of_view_rad

    def margin_db(self, depth_m: float, angle_rad: float = 0.0) -> float:
        """Return by how much a beam's echo exceeds the detector's threshold, at an angle from straight down."""
        parameters, water = acoustics(self.array, self.frequency_khz).parameters, WATERS[self.water]
        absorption_db_m = 1e-3 * _mean_absorption_db_km(self.frequency_khz, self.water, depth_m)
        snr_db, _, needed_db = _core.bottom_echo(
            parameters, bottom_material(ROCK), depth_m / math.cos(angle_rad), angle_rad,
            abs(angle_rad - self.fan.receiver_tilt_rad), water.sound_speed_m_s, absorption_db_m,
        )  # fmt: skip
        return float(snr_db - needed_db)

    def depth_m(self) -> float:
        """Return the maximum depth."""
        return float(brentq(self.margin_db, 0.5, DEEPEST_M, xtol=1e-4))

    def swath_m(self, depth_m: float) -> float:
        """Return the swath width at a depth."""
        outermost = min(self.half_fan_rad, math.acos(min(1.0, depth_m / self.fan.range_max_m)))
        if self.margin_db(depth_m) <= 0.0:
            return 0.0
        if self.margin_db(depth_m, outermost) < 0.0:
            outermost = float(brentq(lambda angle: self.margin_db(depth_m, angle), 0.0, outermost, xtol=1e-6))
        return 2.0 * depth_m * math.tan(outermost)

    def coverage(self) -> Swath:
        """Return the widest swath."""
        deepest_m = self.depth_m()
        found = minimize_scalar(
            lambda share: -self.swath_m(share * deepest_m),
            bounds=(0.05, 1.0),
            method="bounded",
            options={"xatol": 1e-4},
        )
        return Swath(-float(found.fun), float(found.x) * deepest_m)


@lru_cache(maxsize=4096)
def _mean_absorption_db_km(frequency_khz: int, water: str, depth_m: float) -> float:
    """Return the mean absorption (Francois and Garrison) by Gauss-Legendre quadrature, smooth in depth."""
    places, weights = np.polynomial.legendre.leggauss(4)
    salinity_psu = WATERS[water].salinity_psu
    return float(
        sum(
            0.5
            * weight
            * _core.absorption_db_km(
                1e3 * frequency_khz, TEMPERATURE_DEG_C, salinity_psu, 0.5 * (1 + place) * depth_m, ACIDITY_PH
            )
            for place, weight in zip(places, weights, strict=True)
        )
    )


def _cells(rows: dict[tuple[str, str], tuple[float, ...]], receivers: Literal[1, 2] = 1) -> dict[Cell, float]:
    """Return the metres of a column of the table by cell; a row of three ends at 400 kHz."""
    return {
        Cell(array, frequency, water, receivers): metres
        for (array, water), row in rows.items()
        for frequency, metres in zip(FREQUENCIES_KHZ, row, strict=False)
    }


# Fig. 8 of the paper: rock, BS = -30 dB, NL = 45 dB, PR enabled.
DEPTH_M = _cells(
    {
        ("em2040-04", "ocean"): (635.0, 480.0, 315.0, 95.0, 55.0),
        ("em2040-04", "fresh"): (1360.0, 740.0, 430.0, 115.0, 60.0),
        ("em2040-07", "ocean"): (600.0, 465.0, 300.0, 85.0, 50.0),
        ("em2040-07", "fresh"): (1300.0, 700.0, 375.0, 105.0, 55.0),
    }
)
SINGLE_COVERAGE_M = _cells(
    {
        ("em2040-04", "ocean"): (920.0, 670.0, 410.0, 130.0, 27.0),
        ("em2040-04", "fresh"): (1990.0, 1100.0, 570.0, 150.0, 30.0),
        ("em2040-07", "ocean"): (880.0, 640.0, 385.0, 120.0, 25.0),
        ("em2040-07", "fresh"): (1870.0, 1050.0, 540.0, 140.0, 28.0),
    }
)
DUAL_COVERAGE_M = _cells(
    {
        ("em2040-04", "ocean"): (980.0, 760.0, 430.0),
        ("em2040-04", "fresh"): (2110.0, 1270.0, 610.0),
        ("em2040-07", "ocean"): (930.0, 725.0, 410.0),
        ("em2040-07", "fresh"): (2000.0, 1200.0, 570.0),
    },
    receivers=2,
)
COVERAGE_M = SINGLE_COVERAGE_M | DUAL_COVERAGE_M


@lru_cache(maxsize=64)
def _packaged_fan(array: str, frequency_khz: int, receivers: Literal[1, 2]) -> _core.MultibeamModel:
    return multibeam_model(load_sonar(array).with_receivers(receivers, 1e3 * frequency_khz), 1e3 * frequency_khz)


@lru_cache(maxsize=32)
def acoustics(array: str, frequency_khz: int) -> _core.AcousticSpec:
    """Return the packaged instrument's acoustic parameters."""
    return acoustic_spec(load_sonar(array), 1e3 * frequency_khz)
