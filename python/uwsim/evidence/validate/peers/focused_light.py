"""Compares the sun's light that waves focus on a bed with Mitsuba 3, through the same surface; in the suite `camera`.

tests/python/data/make_mitsuba_caustics.py computed the stored results. Mitsuba refracts every ray by Snell's law at a
rough dielectric with the heights of uwsim's own ripples and waves, and scatters it as often as it is scattered, by
Fournier and Forand's phase function. It takes the surface from uwsim, and the slopes of the waves that are too short to
be drawn: it judges the optics, not the sea.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.texts.json_text import read_json
from uwsim.evidence.validate.check import Check, along, relative
from uwsim.evidence.validate.pictures import box_scene

RESULTS = Path(__file__).parent / "mitsuba_caustics.json"
TILE_M, CELL_M = 6.4, 0.05
"""The ripples' tile; the cells of the patterns, of both."""
SUN_RADIUS_RAD = 0.00465
COARSE_M, FINEST_M = 0.8, 0.2
"""Waves of light are separated at COARSE_M; those shorter than FINEST_M, four cells, are left out."""
BAND = 1
"""The band at 550 nm, whose pattern stands for all."""
ALBEDO = 0.5
AZIMUTH_RAD, WIND_TOWARDS_RAD, TIME_S = 0.7, 0.3, 5.0


class Spread(NamedTuple):
    """The standard deviation of the sun's light over its mean: of all waves of light, of long ones, of short ones."""

    all: float
    long: float
    short: float


@dataclass(frozen=True)
class Case:
    """A bed under a sea. sea: significant height [m] and peak period [s] of waves besides the ripples."""

    depth_m: float
    wind_m_s: float = 5.0
    jerlov: str = "IB"
    sea: tuple[float, float] | None = None
    sun_deg: float = 50.0

    @property
    def optics(self) -> _core.Optics:
        """The native optics, without particles that are seen one by one."""
        water, sun = _core.WaterOptics.jerlov(self.jerlov), float(np.radians(self.sun_deg))
        return _core.Optics(water, sun, AZIMUTH_RAD, self.wind_m_s, WIND_TOWARDS_RAD, 0.0, 0.0)

    @cached_property
    def scene(self) -> _core.CameraScene:
        """A grey plate at this depth, under the waves."""
        plate = box_scene((0, 0, -self.depth_m - 0.5), (90, 90, 1))
        if self.sea is None:
            return plate
        return plate.with_water(self.water, 0)

    @cached_property
    def water(self) -> _core.Water:
        """The water with its waves."""
        water = _core.Water()
        if self.sea is not None:
            water.waves = _core.Waves.jonswap(*self.sea, heading_rad=WIND_TOWARDS_RAD, spreading_exponent=4.0, seed=1)
        return water

    @property
    def side(self) -> int:
        """The cells along each axis of the patch of bed: the ripples' tile, or four where waves do not repeat in it."""
        return round((1 if self.sea is None else 2) * TILE_M / CELL_M)

    @property
    def half_m(self) -> float:
        """Half of the patch's side."""
        return 0.5 * self.side * CELL_M

    @property
    def margin_m(self) -> float:
        """The sea around the patch from which light comes, too, where it does not repeat."""
        return 0.0 if self.repeats else 4.0

    @property
    def repeats(self) -> bool:
        """True if the sea repeats beyond the patch."""
        return self.sea is None

    @property
    def to_sun(self) -> tuple[float, float, float]:
        """The direction to the sun in air."""
        x, y, z = np.ravel(self.optics.to_sun_world)
        return float(x), float(y), float(z)

    @property
    def shift_m(self) -> tuple[float, float]:
        """The place on still water through which the sun shines on the middle of the patch."""
        x, y, z = np.ravel(self.optics.to_sun_below_world)
        return float(self.depth_m * x / z), float(self.depth_m * y / z)

    @property
    def index(self) -> float:
        """The water's refractive index."""
        return float(self.optics.water.refractive_index)

    @property
    def attenuation_per_m(self) -> float:
        """The light absorbed or scattered."""
        return float(self.optics.water.absorption[BAND] + self.optics.water.scattering[BAND])

    @property
    def albedo(self) -> float:
        """The share of the attenuated light that is scattered."""
        return float(self.optics.water.scattering[BAND]) / self.attenuation_per_m

    @property
    def molecular(self) -> float:
        """The share of the scattered light that molecules scatter: what water of type I scatters."""
        own = float(self.optics.water.scattering[BAND])
        return min(1.0, float(_core.WaterOptics.jerlov("I").scattering[BAND]) / own)

    @property
    def roughness(self) -> float:
        """Beckmann's roughness by waves too short to be drawn, with half of Cox and Munk's variance: ripples.h."""
        return float(np.sqrt(0.5 * (0.003 + 0.00512 * self.wind_m_s)))

    def ripple_slopes(self) -> Floats:
        """Return the slopes (n, n, 2) of the ripples' tile, [y][x]."""
        return np.asarray(self.scene.ripple_slopes(self.optics, TIME_S), np.float64)

    def pattern(self) -> Floats:
        """Return uwsim's light on each cell of the bed [x][y] over the mean of the sun's light there, less its mean."""
        above_m = 0.75 * self.depth_m
        focal, middle = above_m / CELL_M, 0.5 * (self.side - 1)
        camera = _core.Camera("check", _core.Lens(self.side, self.side, focal, focal, middle, middle))
        down = Rotation.from_euler("Y", 90, degrees=True).as_quat()
        place = (0.0, 0.0, above_m - self.depth_m)
        picture = self.scene.render(camera, self.optics, place, down, TIME_S, 0, ["sunlight", "caustics"],
                                    keep_radiance=True)  # fmt: skip
        light = np.asarray(picture.radiance, np.float64)[::-1, ::-1, BAND] * np.pi / ALBEDO
        kd = float(self.optics.water.diffuse_attenuation[BAND])
        sun = float(np.ravel(self.optics.sun_irradiance_below())[BAND]) * np.exp(-kd * self.depth_m)
        return np.asarray((light - light.mean()) / sun)


CASES = {
    "8 m, I, wind 5 m/s, sun overhead": Case(8.0, jerlov="I", sun_deg=90.0),
    "2 m, IB, wind 5 m/s": Case(2.0),
    "8 m, IB, wind 5 m/s": Case(8.0),
    "20 m, IB, wind 5 m/s": Case(20.0),
    "8 m, IB, wind 10 m/s": Case(8.0, wind_m_s=10.0),
    "8 m, 3C, wind 5 m/s": Case(8.0, jerlov="3C"),
    "8 m, IB, wind 5 m/s, waves of 0.5 m, 3 s": Case(8.0, sea=(0.5, 3.0)),
}

TOLERANCE = 0.2
"""The most by which the spreads may differ; docs/inside/reality.md has what they differ by, and why."""


def checks() -> list[Check]:
    """Return a check of each case: the standard deviation of the sun's light on the bed over its mean."""
    kept = read_json(RESULTS)
    peer = f"sun's light on a bed, Mitsuba {kept['mitsuba']}"
    given = [kept["cases"][name]["slopes_rms"] for name in CASES]
    own = [slopes_rms(case) for case in CASES.values()]
    found = [along(peer, "slopes of the ripples that Mitsuba was given", given, own, 1.0, 1e-5)]
    for name, case in CASES.items():
        theirs = kept["cases"][name]
        found.append(relative(peer, name, theirs["all"], spread_of([case.pattern()]).all, TOLERANCE))
    return found


def slopes_rms(case: Case) -> float:
    """Return the rms of the ripples' slopes, by which the surface is known again."""
    return float(np.sqrt((case.ripple_slopes() ** 2).sum(axis=-1).mean()))


def height_map(case: Case, spacing_m: float) -> tuple[Floats, Floats]:
    """Return places (n, n, 2) about where the light of the patch enters, and the heights (n, n) of the water there."""
    slopes = case.ripple_slopes().transpose(1, 0, 2)
    n, finer = len(slopes), round(TILE_M / spacing_m)
    wave = 2 * np.pi / TILE_M * np.fft.fftfreq(n, 1 / n)
    kx, ky = np.meshgrid(wave, wave, indexing="ij")
    square = np.maximum(kx**2 + ky**2, 1e-12)
    found = -1j * (kx * np.fft.fft2(slopes[..., 0]) + ky * np.fft.fft2(slopes[..., 1])) / square
    padded = np.zeros((finer, finer), complex)
    at = np.fft.fftfreq(n, 1 / n).astype(int) % finer
    padded[np.ix_(at, at)] = found
    tile = np.fft.ifft2(padded).real * (finer / n) ** 2
    reach = round((case.half_m + case.margin_m + 0.6) / spacing_m)
    x, y = (np.arange(-reach, reach + 1) + round(shift / spacing_m) for shift in case.shift_m)
    heights = tile[np.ix_(x % finer, y % finer)]
    places = np.stack(np.meshgrid(x * spacing_m, y * spacing_m, indexing="ij"), axis=-1)
    if case.sea is not None:
        heights = heights + np.reshape(case.water.surface_height_m(places.reshape(-1, 2), TIME_S), heights.shape)
    return places, heights


def spread_of(patterns: Sequence[Floats]) -> Spread:
    """Return the spread of a pattern; of several of the same light, without what their noise adds to it."""
    waves = [np.fft.fft2(pattern - pattern.mean()) / pattern.size for pattern in patterns]
    power = np.abs(np.sum(waves, axis=0)) ** 2
    if len(waves) > 1:  # products of different patterns only, whose noise is not the same
        power = (power - np.sum(np.abs(waves) ** 2, axis=0)) / (len(waves) * (len(waves) - 1))
    n = len(patterns[0])
    per_m = np.fft.fftfreq(n, CELL_M)
    wave_per_m = np.hypot(*np.meshgrid(per_m, per_m, indexing="ij"))
    is_long, is_seen = wave_per_m <= 1 / COARSE_M, wave_per_m <= 1 / FINEST_M
    parts = [power[is_seen].sum(), power[is_long].sum(), power[is_seen & ~is_long].sum()]
    return Spread(*(float(np.sqrt(max(part, 0.0))) for part in parts))
