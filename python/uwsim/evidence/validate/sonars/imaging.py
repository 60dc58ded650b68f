"""The imaging suite: the packaged imaging sonars over a flat bed, compared with the sonar equation.

Expected values are computed here from published formulas, independently of the code under test. The native tests
ForwardLooking, SideScan, SingleBeam and Speckle have the geometry, the gain, the speckle and the profile.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, along
from uwsim.evidence.validate.sonars.instrument import flat_world
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.imaging import Acoustics, ForwardLooking, SideScan

BED_M, HEIGHT_M = -30.0, 6.0
BED_DB = -30.0  # arbitrary
SILENCE_DB = -200.0
AHEAD_TOLERANCE_DB, ASIDE_TOLERANCE_DB = 0.25, 0.05  # sampling errors of the packaged models
TILT_RAD = np.radians(12.0)  # of the forward-looking head
HAMMING = 0.46  # taper of the vertical patterns' windows
EDGE_SHARE = 0.04  # share of the main lobe that is excluded at each of its ends


@dataclass(frozen=True)
class Basin:
    """A flat bed, usable as a uwsim.instruments.sonars.imaging.Place."""

    world: _core.World
    scene: _core.RayScene
    strengths_db: dict[str, float]
    seed: int = 1
    threads: int = 1
    time_ns: int = 0


def run() -> list[Check]:
    """Return the checks of the suite."""
    return [bed_ahead(ForwardLooking()), bed_aside(SideScan())]


def basin() -> Basin:
    """Return a flat bed."""
    world = flat_world(-BED_M, 300.0)
    return Basin(world, _core.RayScene(world), {"terrain": BED_DB})


def pattern_power(off_axis_rad: Floats, width_rad: float, taper: float) -> Floats:
    """Return a line array's power pattern with a raised-cosine window, by direct summation over the aperture."""
    return _power(_half_power(taper) / np.sin(width_rad / 2) * np.sin(np.atleast_1d(off_axis_rad)), taper)


@cache
def _half_power(taper: float) -> float:
    """Return the sine of the angle of half power, times the aperture in wavelengths."""
    waves = np.linspace(0.0, 1.0, 20001)
    return float(np.interp(0.5, _power(waves, taper)[::-1], waves[::-1]))


def _power(waves: Floats, taper: float) -> Floats:
    """Return the power at sines of angles times the aperture in wavelengths."""
    places = (np.arange(1000) + 0.5) / 2000  # of one half, which the other mirrors
    window = (1 - taper) + taper * np.cos(2 * np.pi * places)
    few = np.array_split(waves, 1 + len(waves) // 500)
    sums = np.concatenate([np.cos(2 * np.pi * np.outer(part, places)) @ window for part in few])
    return np.asarray((sums / window.sum()) ** 2, np.float64)


def sonar_equation_db(
    model: Acoustics, ranges_m: Floats, width_rad: float, vertical: Floats, per_range: Floats
) -> Floats:
    """Return the level of a flat bed: SL - 40 log R - 2 alpha R + BS + 20 log cos i + 10 log (cell area x pattern).

    width_rad: the beam's equivalent width. per_range: metres of bed along the range per metre of slant range.
    """
    water = _core.Water()
    depth_m = -(BED_M + HEIGHT_M)
    alpha_db_m = (
        _core.absorption_db_km(model.frequency_hz, water.temperature_deg_c(-depth_m), water.salinity_psu, depth_m) / 1e3
    )
    area_m2 = ranges_m * width_rad * model.bin_m * per_range
    lost_db = 40 * np.log10(ranges_m) + 2 * alpha_db_m * ranges_m
    bed_db = BED_DB if model.bottom_strength_db is None else model.bottom_strength_db
    lambert_db = bed_db + 20 * np.log10(HEIGHT_M / ranges_m)
    return np.asarray(model.source_level_db - lost_db + lambert_db + 10 * np.log10(area_m2 * vertical), np.float64)


def seen_ahead(model: ForwardLooking) -> imaging.SonarImage:
    """Return what a forward-looking sonar sees of the bed, without noise and gain."""
    quiet = replace(model, looks=0, noise_level_db=SILENCE_DB, time_varied_gain=False, beams=model.beams | 1)
    return imaging.look_ahead(basin(), imaging.pose_matrix((0, 0, BED_M + HEIGHT_M), pitch_rad=TILT_RAD), quiet)


def bed_ahead(model: ForwardLooking, image: imaging.SonarImage | None = None) -> Check:
    """Check the level of the bed in the central beam of a forward-looking sonar. image: by default, its own."""
    image = image or seen_ahead(model)
    off_axis_rad = np.arcsin(np.minimum(HEIGHT_M / image.ranges_m, 1.0)) - TILT_RAD
    shown = np.abs(off_axis_rad) < model.vertical_width_rad * (1 - EDGE_SHARE)
    around = np.linspace(-6 * model.beam_width_rad, 6 * model.beam_width_rad, 6001)
    power = np.maximum(pattern_power(around, model.beam_width_rad, model.taper), 1e-4)
    ranges_m, off_axis_rad = image.ranges_m[shown], off_axis_rad[shown]
    vertical = np.maximum(pattern_power(off_axis_rad, model.vertical_width_rad, HAMMING), 1e-4)
    # Beams are planes through the tilted head's z axis: they widen by the cosine of the elevation from its level plane.
    spread = np.cos(off_axis_rad) / np.sqrt(1 - (HEIGHT_M / ranges_m) ** 2)
    expected = sonar_equation_db(model, ranges_m, float(np.trapezoid(power, around)), vertical, spread)
    got = image.level_db[shown, image.level_db.shape[1] // 2].astype(np.float64)
    return _check("forward-looking", ranges_m, expected, got, AHEAD_TOLERANCE_DB)


def seen_aside(model: SideScan) -> imaging.Waterfall:
    """Return what a side-scan sonar sees of the bed, without noise and gain."""
    planes = 15  # sufficient to integrate the pattern along the track
    quiet = replace(model, looks=0, noise_level_db=SILENCE_DB, time_varied_gain=False, planes=planes)
    return imaging.look_aside(basin(), [imaging.pose_matrix((0, 0, BED_M + HEIGHT_M))], quiet)


def bed_aside(model: SideScan, waterfall: imaging.Waterfall | None = None) -> Check:
    """Check the level of the bed in the port beam of a side-scan sonar. waterfall: by default, its own."""
    waterfall = waterfall or seen_aside(model)
    shown = waterfall.ranges_m > 1.3 * HEIGHT_M
    ranges_m = waterfall.ranges_m[shown]
    around = np.linspace(-model.along_width_rad, model.along_width_rad, 3001)
    width_rad = float(np.trapezoid(pattern_power(around, model.along_width_rad, HAMMING), around))
    off_axis_rad = np.arcsin(HEIGHT_M / ranges_m) - model.depression_rad
    vertical = np.maximum(pattern_power(off_axis_rad, model.vertical_width_rad, HAMMING), 1e-3)
    expected = sonar_equation_db(model, ranges_m, width_rad, vertical, 1 / np.sqrt(1 - (HEIGHT_M / ranges_m) ** 2))
    got = waterfall.port_db[0, shown].astype(np.float64)
    return _check("side-scan", ranges_m, expected, got, ASIDE_TOLERANCE_DB)


def _check(name: str, ranges_m: Floats, expected: Floats, got: Floats, tolerance_db: float) -> Check:
    return along(
        "sonar equation", f"flat bed, {name}", expected, got, 1.0, tolerance_db, "dB", x=ranges_m, across="range [m]"
    )
