"""Pingers' sound as it arrives at points of the water: when, how loud, by which reflections, from which bearing.

In a `sound.pool`, arrivals are those of image sources: J. B. Allen and D. A. Berkley, "Image method for efficiently
simulating small-room acoustics", J. Acoust. Soc. Am. 65(4), 1979, with coefficients that do not depend on the angle,
in water of one speed of sound, that half-way down. Elsewhere they are those of layered water over a flat bed
(cpp/uwsim/acoustics/arrivals.h). Levels fall by spreading, 20 log10 r, and by the absorption of Francois and Garrison.
Obstacles, vehicles and waves do not change the sound, and a burst is not compressed by motion (no Doppler shift).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import matrix
from uwsim.scenario.spec.link import BOTTOMS
from uwsim.scenario.spec.pinger import Pinger, Pool, Sound
from uwsim.scenario.spec.sensor_kind import DerivedKind, Figure

WITHIN_DB = 40.0
"""Arrivals in open water that are weaker than the strongest by more are left out."""
MOST_BOUNCES = 8
RISE_CYCLES = 3.0


@dataclass(frozen=True)
class Paths:
    """The ways of a pinger's sound to one point, arrays (n,).

    delay_s: travel time. gain: pressure relative to that at 1 m. phase_rad: a tone cos(w t) arrives as
    gain cos(w (t - delay_s) - phase_rad).
    """

    delay_s: Floats
    gain: Floats
    phase_rad: Floats


@dataclass(frozen=True)
class Burst:
    """One burst of a pinger. number: since the beginning of the run. sent_s, arrival_s: simulated times.

    distance_m: from the pinger to the point where it arrives. level_db: rms level there, dB re 1 uPa, on the
    direct way.
    """

    pinger: Pinger
    number: int
    sent_s: float
    arrival_s: float
    distance_m: float
    level_db: float


@dataclass(frozen=True)
class PingerSound:
    """The sound of a scenario's pingers. world: returns the world at present."""

    pingers: Sequence[Pinger]
    sound: Sound
    world: Callable[[], _core.World]

    def in_band(self, low_hz: float, high_hz: float) -> PingerSound:
        """Return the sound of the pingers in a band alone."""
        return replace(self, pingers=[one for one in self.pingers if low_hz <= one.frequency_hz <= high_hz])

    def paths(self, pinger: Pinger, points_m: ArrayLike) -> list[Paths]:
        """Return the ways from a pinger to each of the points (n, 3) of the world; none to points out of the water."""
        points = np.asarray(points_m, np.float64)
        if self.sound.pool is not None:
            speed_m_s, absorption_db_m = self._water(pinger, -0.5 * self.sound.pool.depth_m)
            lengths, coefficients = image_sources(self.sound.pool, pinger.position_m, points)
            found = []
            for point, each in zip(points, lengths, strict=True):
                heard = self.sound.pool.holds(tuple(point))
                gain = heard * coefficients * 10.0 ** (-0.05 * absorption_db_m * each) / np.maximum(each, 1e-3)
                kept = gain != 0.0
                found.append(Paths(each[kept] / speed_m_s, gain[kept], np.zeros(int(kept.sum()))))
            return found
        return [self._layered(pinger, point) for point in points]

    def last_burst(self, point_m: Callable[[float], Floats], until_s: float) -> Burst | None:
        """Return the burst that has arrived last until a time, on the straight way, or None before the first.

        point_m: returns the place (3,) of the listener at a time.
        """
        found = (self._last_of(pinger, point_m, until_s) for pinger in self.pingers)
        return max((each for each in found if each is not None), key=lambda each: each.arrival_s, default=None)

    def noise_db(self, frequencies_hz: Floats) -> Floats:
        """Return the ambient noise at frequencies (n,), dB re 1 uPa^2/Hz: Wenz's curves, valid from 10 Hz to 1 MHz."""
        knots = np.geomspace(10.0, 1e6, 101)
        levels = [_core.ambient_noise_db_hz(each, self.sound.wind_m_s, self.sound.shipping) for each in knots]
        return np.asarray(np.interp(np.log(np.maximum(frequencies_hz, 10.0)), np.log(knots), levels))

    def _last_of(self, pinger: Pinger, point_m: Callable[[float], Floats], until_s: float) -> Burst | None:
        arrival_s = until_s
        for _ in range(3):  # the listener's place depends on the arrival, which depends on the place
            point = point_m(arrival_s)
            distance_m = float(np.linalg.norm(point - pinger.position_m))
            speed_m_s, absorption_db_m = self._water(pinger, 0.5 * (min(float(point[2]), 0.0) + pinger.position_m[2]))
            delay_s = distance_m / speed_m_s
            number = math.floor((until_s - delay_s - pinger.first_s) / pinger.period_s)
            sent_s = pinger.first_s + number * pinger.period_s
            arrival_s = sent_s + delay_s
        if number < 0 or point[2] > 0.0:
            return None
        level_db = pinger.level_db - 20.0 * math.log10(max(distance_m, 1e-3)) - absorption_db_m * distance_m
        return Burst(pinger, number, sent_s, arrival_s, distance_m, level_db)

    def _water(self, pinger: Pinger, height_m: float) -> tuple[float, float]:
        """Return the speed of sound [m/s] and the absorption of the pinger's tone [dB/m] at a height in the world."""
        water = self.world().water
        depth_m = -height_m
        temperature, salinity = water.temperature_deg_c(height_m), water.salinity_at_psu(height_m)
        alpha = _core.absorption_db_km(pinger.frequency_hz, temperature, salinity, depth_m)
        return _core.sound_speed_profile(water).at(depth_m), 1e-3 * alpha

    def _layered(self, pinger: Pinger, point: Floats) -> Paths:
        world, source = self.world(), np.array(pinger.position_m)
        if point[2] > 0.0:
            return Paths(*np.zeros((3, 0)))
        middle = 0.5 * (source + point)
        bed_m = -float(np.asarray(world.height_at(middle[None, :2]))[0])
        if not bed_m > -min(source[2], point[2]):  # also where the bed is unknown
            bed_m = math.inf
        _, absorption_db_m = self._water(pinger, middle[2])
        found = _core.arrivals(
            _core.sound_speed_profile(world.water), -source[2], -point[2], float(np.hypot(*(point - source)[:2])),
            bed_m, pinger.frequency_hz, BOTTOMS[self.sound.bottom], absorption_db_km=1e3 * absorption_db_m,
            within_db=WITHIN_DB, most_bounces=MOST_BOUNCES,
        )  # fmt: skip
        rows = np.array([(one.time_s, 10.0 ** (0.05 * one.level_db), one.phase_rad) for one in found]).reshape(-1, 3)
        return Paths(*rows.T)


def image_sources(pool: Pool, source_m: ArrayLike, points_m: ArrayLike) -> tuple[Floats, Floats]:
    """Return the lengths (n, k) of all ways from a source (3,) to points (n, 3), and their coefficients (k,).

    A way has at most `pool.order` reflections; the first is the direct one. Reflecting image m of an axis lies |m|
    reflections away, in cells that repeat the pool.
    """
    (low, high), order = pool.bounds_m(), pool.order
    cells = np.stack(np.meshgrid(*[np.arange(-order, order + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    cells = cells[np.abs(cells).sum(axis=1) <= order]
    cells = cells[np.argsort(np.abs(cells).sum(axis=1), kind="stable")]
    within = np.asarray(source_m, np.float64) - low
    size = high - low
    images = low + cells * size + np.where(cells % 2 == 0, within, size - within)
    # From the lower side, an image of odd m > 0 has one reflection more at the upper face, of m < 0 at the lower one.
    near, far = np.abs(cells) // 2, (np.abs(cells) + 1) // 2
    upper, lower = np.where(cells > 0, far, near), np.where(cells > 0, near, far)
    coefficients = np.array([pool.walls, pool.walls, pool.surface]) ** upper
    coefficients *= np.array([pool.walls, pool.walls, pool.floor]) ** lower
    ways = np.asarray(points_m, np.float64)[:, None, :] - images[None]
    return np.linalg.norm(ways, axis=2), coefficients.prod(axis=1)


def tone(pinger: Pinger, ages_s: Floats, phase_rad: float) -> Floats:
    """Return a burst's pressure at 1 m [uPa] at times (n,) since its beginning; zero outside of it."""
    rise_s = min(RISE_CYCLES / pinger.frequency_hz, 0.5 * pinger.pulse_s)
    share = np.clip(np.minimum(ages_s, pinger.pulse_s - ages_s) / rise_s, 0.0, 1.0)
    peak = math.sqrt(2.0) * 10.0 ** (0.05 * pinger.level_db)
    wave = np.cos(2.0 * np.pi * pinger.frequency_hz * ages_s - phase_rad)
    pressure: Floats = peak * 0.5 * (1.0 - np.cos(np.pi * share)) * wave
    return pressure


def bearing(
    values: Mapping[str, Any], figures: Mapping[str, float], time_s: float, ping: Callable[..., Burst | None]
) -> dict[str, float]:
    """Return the direction, straight to the pinger, of the last burst since the sample before.

    It is that at the time of the sample. All are NaN without a burst in the band, and below the threshold.
    """
    place = np.asarray(values["position_m"], np.float64)
    burst = ping(place, figures["low_hz"], figures["high_hz"])
    if burst is None or burst.level_db < figures["threshold_db"]:
        return dict.fromkeys(FIELDS, math.nan)
    x, y, z = matrix(values["orientation_xyzw"]).T @ (burst.pinger.position_m - place)
    return {
        "azimuth_rad": math.atan2(y, x),
        "elevation_rad": math.atan2(z, math.hypot(x, y)),
        "level_db": burst.level_db,
        "frequency_hz": burst.pinger.frequency_hz,
    }


FIELDS = {"azimuth_rad": (1, "rad"), "elevation_rad": (1, "rad"), "level_db": (1, "dB"), "frequency_hz": (1, "Hz")}

BEARING = DerivedKind(
    name="bearing",
    meaning="direction of a pinger (azimuth from x to y, elevation up is positive), in the sample after each ping",
    source="ins",
    fields=FIELDS,
    measure=bearing,
    listens=True,
    parameters={
        "low_hz": Figure(200.0, 0.0, 1e6, "Hz", "lowest frequency that it detects"),
        "high_hz": Figure(250e3, 0.0, 1e6, "Hz", "highest frequency that it detects"),
        "threshold_db": Figure(100.0, 0.0, 300.0, "dB re 1 uPa", "lowest level of a burst that it detects"),
    },
)
