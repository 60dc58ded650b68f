"""The imaging suite: the packaged imaging sonars over a flat bed, compared with the sonar equation and geometry.

Expected values are computed here from published formulas, independently of the code under test.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.whole_trimesh import trimesh
from uwsim.evidence.validate.check import Check, along, relative, within
from uwsim.figures.style import save_figure
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.imaging import Acoustics, ForwardLooking, SideScan, SingleBeam

Array = NDArray[np.float64]
BED_M, HEIGHT_M = -30.0, 6.0
BED_DB, BOX_DB = -30.0, -15.0  # arbitrary, but different
SILENCE_DB = -200.0
AHEAD_TOLERANCE_DB, ASIDE_TOLERANCE_DB = 0.25, 0.05  # sampling errors of the packaged models
HAMMING = 0.46  # taper of the vertical patterns' windows
EDGE_SHARE = 0.04  # share of the main lobe that is excluded at each of its ends
EVEN_APERTURE_RAD = np.radians(170.0)


@dataclass(frozen=True)
class Basin:
    """A flat bed with boxes, usable as a uwsim.instruments.sonars.imaging.Place."""

    world: _core.World
    scene: _core.RayScene
    strengths_db: dict[str, float]
    seed: int = 1
    threads: int = 1
    time_ns: int = 0


def run(out: Path | None = None) -> list[Check]:
    """Return the checks of the suite; draw the level of the bed over range into the folder `out`."""
    curves = [bed_level_ahead(ForwardLooking()), bed_level_aside(SideScan())]
    if out is not None:
        draw_levels(curves, out / "imaging_bed_level.png")
    checks = [
        along("sonar equation", f"flat bed, {curve.name}", curve.expected, curve.got, 1.0, tolerance, "dB")
        for curve, tolerance in zip(curves, (AHEAD_TOLERANCE_DB, ASIDE_TOLERANCE_DB), strict=True)
    ]
    return [*checks, *gain_checks(), *geometry_checks(), *speckle_checks(), *profile_checks()]


@dataclass(frozen=True)
class Level:
    """The level received from a flat bed as a function of range, expected and simulated [dB re 1 uPa]."""

    name: str
    ranges_m: Array
    expected: Array
    got: Array


def basin(*boxes: tuple[tuple[float, float, float], tuple[float, float, float]]) -> Basin:
    """Return a flat bed with boxes, each given by its centre and size."""
    world = _core.World()
    world.set_terrain(np.full((2, 2), BED_M, np.float32), 600.0, (-300.0, -300.0))
    for k, (middle_m, size_m) in enumerate(boxes):
        box = trimesh.creation.box(size_m)
        world.add_solid(f"box{k}", box.vertices + np.array(middle_m), box.faces)
    strengths_db = dict.fromkeys(world.label_names, BOX_DB) | {"terrain": BED_DB}
    return Basin(world, _core.RayScene(world), strengths_db)


def pattern_power(off_axis_rad: Array, width_rad: float, taper: float) -> Array:
    """Return a line array's power pattern with a raised-cosine window, by direct summation over the aperture."""
    return _power(_half_power(taper) / np.sin(width_rad / 2) * np.sin(np.atleast_1d(off_axis_rad)), taper)


@cache
def _half_power(taper: float) -> float:
    """Return the sine of the angle of half power, times the aperture in wavelengths."""
    waves = np.linspace(0.0, 1.0, 20001)
    return float(np.interp(0.5, _power(waves, taper)[::-1], waves[::-1]))


def _power(waves: Array, taper: float) -> Array:
    """Return the power at sines of angles times the aperture in wavelengths."""
    places = (np.arange(1000) + 0.5) / 2000  # of one half, which the other mirrors
    window = (1 - taper) + taper * np.cos(2 * np.pi * places)
    few = np.array_split(waves, 1 + len(waves) // 500)
    sums = np.concatenate([np.cos(2 * np.pi * np.outer(part, places)) @ window for part in few])
    return np.asarray((sums / window.sum()) ** 2, np.float64)


def sonar_equation_db(model: Acoustics, ranges_m: Array, width_rad: float, vertical: Array, per_range: Array) -> Array:
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


def bed_level_ahead(model: ForwardLooking, believed: ForwardLooking | None = None) -> Level:
    """Return the level in the central beam of a forward-looking sonar.

    believed: the model assumed for the expected levels; defaults to the same model.
    """
    tilt_rad = np.radians(12.0)
    quiet = replace(model, looks=0, noise_level_db=SILENCE_DB, time_varied_gain=False, beams=model.beams | 1)
    image = imaging.look_ahead(basin(), imaging.pose_matrix((0, 0, BED_M + HEIGHT_M), pitch_rad=tilt_rad), quiet)
    believed = believed or model
    off_axis_rad = np.arcsin(np.minimum(HEIGHT_M / image.ranges_m, 1.0)) - tilt_rad
    shown = np.abs(off_axis_rad) < believed.vertical_width_rad * (1 - EDGE_SHARE)
    around = np.linspace(-6 * believed.beam_width_rad, 6 * believed.beam_width_rad, 6001)
    width_rad = float(
        np.trapezoid(np.maximum(pattern_power(around, believed.beam_width_rad, believed.taper), 1e-4), around)
    )
    ranges_m, off_axis_rad = image.ranges_m[shown], off_axis_rad[shown]
    vertical = np.maximum(pattern_power(off_axis_rad, believed.vertical_width_rad, HAMMING), 1e-4)
    # Beams are planes through the tilted head's z axis: they widen by the cosine of the elevation from its level plane.
    spread = np.cos(off_axis_rad) / np.sqrt(1 - (HEIGHT_M / ranges_m) ** 2)
    expected = sonar_equation_db(believed, ranges_m, width_rad, vertical, spread)
    return Level("forward-looking", ranges_m, expected, image.level_db[shown, quiet.beams // 2].astype(np.float64))


def bed_level_aside(model: SideScan, believed: SideScan | None = None) -> Level:
    """Return the level in the port beam of a side-scan sonar."""
    planes = 15  # sufficient to integrate the pattern along the track
    quiet = replace(model, looks=0, noise_level_db=SILENCE_DB, time_varied_gain=False, planes=planes)
    waterfall = imaging.look_aside(basin(), [imaging.pose_matrix((0, 0, BED_M + HEIGHT_M))], quiet)
    believed = believed or model
    shown = waterfall.ranges_m > 1.3 * HEIGHT_M
    ranges_m = waterfall.ranges_m[shown]
    around = np.linspace(-believed.along_width_rad, believed.along_width_rad, 3001)
    width_rad = float(np.trapezoid(pattern_power(around, believed.along_width_rad, HAMMING), around))
    off_axis_rad = np.arcsin(HEIGHT_M / ranges_m) - believed.depression_rad
    vertical = np.maximum(pattern_power(off_axis_rad, believed.vertical_width_rad, HAMMING), 1e-3)
    expected = sonar_equation_db(believed, ranges_m, width_rad, vertical, 1 / np.sqrt(1 - (HEIGHT_M / ranges_m) ** 2))
    return Level("side-scan", ranges_m, expected, waterfall.port_db[0, shown].astype(np.float64))


def gain_checks() -> list[Check]:
    """Check that time-varied gain makes a flat bed uniform; without it, two frequencies differ by absorption."""
    even = ForwardLooking(looks=0, noise_level_db=SILENCE_DB, vertical_width_rad=float(EVEN_APERTURE_RAD), beams=3,
                          field_of_view_rad=0.05, rays_per_column=3000)  # fmt: skip
    head = imaging.pose_matrix((0, 0, BED_M + HEIGHT_M))
    level_db = imaging.look_ahead(basin(), head, even).level_db[:, 1]
    far_bed = level_db[even.bin_centres_m > 3 * HEIGHT_M]
    checks = [within("gain", "unevenness of a flat bed", 0.0, float(np.ptp(far_bed)), 1.0, 0.5, "dB")]
    raw = [
        imaging.look_ahead(basin(), head, replace(even, time_varied_gain=False, frequency_hz=hertz)).level_db[:, 1]
        for hertz in (300e3, 900e3)
    ]
    water = _core.Water()
    low, high = (
        _core.absorption_db_km(hertz, water.temperature_deg_c(BED_M + HEIGHT_M), 0.0, -(BED_M + HEIGHT_M)) / 1e3
        for hertz in (300e3, 900e3)
    )
    far = int(35.0 / even.bin_m)
    expected = 2 * (high - low) * even.bin_centres_m[far]
    checks.append(
        relative("gain", "absorption, 300 to 900 kHz", expected, float(raw[0][far] - raw[1][far]), 3e-3, "dB")
    )
    return checks


def geometry_checks() -> list[Check]:
    """Check the end of a box's shadow, the position of a small target, and the altitude from a side-scan sonar."""
    top, back = 1.5, 15.0
    sim = basin(((back - 0.5, 0.0, BED_M + top / 2), (1.0, 10.0, top)))
    head = imaging.pose_matrix((0, 0, BED_M + HEIGHT_M), pitch_rad=0.2)
    shape = ForwardLooking(looks=0, noise_level_db=SILENCE_DB, beam_width_rad=0.005, beams=3, field_of_view_rad=0.01,
                           columns_per_beam=8, rays_per_column=3000)  # fmt: skip
    middle = imaging.look_ahead(sim, head, shape).level_db[:, 1]
    behind = shape.bin_centres_m > np.hypot(back, HEIGHT_M - top) + 0.5
    ends = shape.bin_centres_m[behind][np.argmax(middle[behind] > 0.0)] - shape.bin_m / 2
    expected = float(np.hypot(back * HEIGHT_M / (HEIGHT_M - top), HEIGHT_M))
    checks = [within("geometry", "end of a box's shadow", expected, float(ends), shape.bin_m, 2.0, "m")]

    bearing = np.radians(31.0)
    place = (20.0 * np.cos(bearing), 20.0 * np.sin(bearing), BED_M + HEIGHT_M)
    model = ForwardLooking(looks=0)
    image = imaging.look_ahead(basin((place, (0.1, 0.1, 0.1))), imaging.pose_matrix((0, 0, BED_M + HEIGHT_M)), model)
    row, column = np.unravel_index(np.argmax(image.level_db - image.noise_db[:, None]), image.level_db.shape)
    spacing = model.field_of_view_rad / (model.beams - 1)
    checks.append(within("geometry", "range of a target", 20.0, float(image.ranges_m[row]), model.bin_m, 2.5, "m"))
    found = float(image.bearings_rad[column])
    checks.append(within("geometry", "bearing of a target", float(bearing), found, spacing, 1.0, "rad"))

    side = SideScan()
    altitude = imaging.look_aside(basin(), [imaging.pose_matrix((0, 0, BED_M + HEIGHT_M))], side).altitude_m[0]
    checks.append(within("geometry", "first return of a side-scan", HEIGHT_M, float(altitude), side.bin_m, 1.0, "m"))
    return checks


def speckle_checks() -> list[Check]:
    """Check that pure noise has a Rayleigh amplitude and a gamma-distributed power that depends on the looks."""
    checks = []
    deep = imaging.pose_matrix((0, 0, BED_M / 2), pitch_rad=-1.2)
    for looks in (1, 4):
        model = ForwardLooking(looks=looks, range_max_m=5.0, rays_per_column=2)
        image = imaging.look_ahead(basin(), deep, model)
        power = 10 ** ((image.level_db - image.noise_db[:, None]).astype(np.float64) / 10)
        name = f"mean / standard deviation of power, {looks} look{'s' if looks > 1 else ''}"
        checks.append(relative("speckle", name, np.sqrt(looks), float(power.mean() / power.std()), 0.01))
        if looks == 1:
            rayleigh = float(np.sqrt(np.pi / (4 - np.pi)))
            got = float(np.sqrt(power).mean() / np.sqrt(power).std())
            checks.append(relative("speckle", "mean / standard deviation of amplitude", rayleigh, got, 0.01))
    return checks


def profile_checks() -> list[Check]:
    """Check that the pencil beam measures a flat bed at height / cosine, averaged over positions to reduce speckle."""
    checks = []
    poses = [imaging.pose_matrix((x, 0, BED_M + HEIGHT_M), pitch_rad=np.pi / 2) for x in np.arange(50.0)]
    place, model = basin(), SingleBeam()
    for angle_deg in (0.0, 30.0, 45.0):
        ranges = np.concatenate([imaging.profile(place, pose, np.radians(angle_deg), model).ranges_m for pose in poses])
        expected = HEIGHT_M / np.cos(np.radians(angle_deg))
        checks.append(
            relative("profile", f"flat bed under {angle_deg:g} deg", float(expected), float(ranges.mean()), 3e-3, "m")
        )
    return checks


def draw_levels(levels: list[Level], path: Path) -> None:
    """Draw the expected and simulated levels of the flat bed against range."""
    figure, panel = plt.subplots(figsize=(9, 4.5), layout="constrained", dpi=120)
    for level, colour in zip(levels, ("C1", "C0"), strict=True):
        panel.plot(level.ranges_m, level.expected, lw=4, alpha=0.35, color=colour, label=f"{level.name}, expected")
        panel.plot(level.ranges_m, level.got, lw=1.0, color=colour, label=f"{level.name}, simulated")
    panel.set(title="A flat bed, received level", xlabel="range [m]", ylabel="dB re 1 uPa")
    panel.grid(alpha=0.3)
    panel.legend()
    save_figure(figure, path)
    plt.close(figure)
