"""All arrivals between two points in water whose speed of sound varies with depth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.short_repr import ShortRepr
from uwsim.scenario.spec.link import BOTTOMS

Counts = NDArray[np.int64]


@dataclass(frozen=True, repr=False)
class Arrivals(ShortRepr):
    """The arrivals at a receiver, sorted by time; each array has one value per arrival.

    level_db: level relative to the source's at 1 m. phase_rad: sound sent as cos(w t) arrives as cos(w (t - time_s) -
    phase_rad). launch_rad, arrival_rad: angles below the horizontal, in the direction of travel. turns: number of
    turning points.
    """

    time_s: Floats
    level_db: Floats
    phase_rad: Floats
    launch_rad: Floats
    arrival_rad: Floats
    length_m: Floats
    surface_bounces: Counts
    bottom_bounces: Counts
    turns: Counts

    def __len__(self) -> int:
        return len(self.time_s)


def arrivals(
    profile: ArrayLike,
    source_depth_m: float,
    receiver_depth_m: float,
    range_m: float,
    bottom: str | Sequence[float] | None = "sand",
    *,
    bottom_depth_m: float | None = None,
    frequency_hz: float = 25_000.0,
    surface_rms_m: float = 0.0,
    absorption_db_km: float = 0.0,
    within_db: float = 40.0,
    most: int = 500,
) -> Arrivals:
    """Return all arrivals of sound from a source at a receiver, over a flat bottom.

    profile: pairs of (depth_m, speed_m_s), with increasing depths; the speed is linear between them. bottom: clay,
    silt, sand or gravel, or density and speed of sound relative to the water above and attenuation [dB per wavelength];
    None for bottomless water. bottom_depth_m: by default the profile's last depth. surface_rms_m: rms height of the
    waves. absorption_db_km: absorption of the water, constant along the path. Arrivals weaker than the strongest by
    more than within_db are dropped, and of the rest only the `most` strongest are kept; rays that bounce and turn more
    than 1000 times are not found. The model and its limits: cpp/uwsim/acoustics/arrivals.h. Raises ValueError.
    """
    levels = np.asarray(profile, float)
    if levels.ndim != 2 or levels.shape[1] != 2 or len(levels) == 0:
        raise ValueError(f"profile has shape {levels.shape}: must be (n, 2), pairs of depth [m] and speed [m/s]")
    _check_at_least("frequency_hz", frequency_hz, 1.0, "Hz")
    _check_at_least("surface_rms_m", surface_rms_m, 0.0, "m")
    _check_at_least("absorption_db_km", absorption_db_km, 0.0, "dB/km")
    _check_at_least("within_db", within_db, 0.0, "dB")
    _check_at_least("most", most, 1)
    depth_m = math.inf if bottom is None else float(levels[-1, 0] if bottom_depth_m is None else bottom_depth_m)
    found = _core.arrivals(
        _core.SoundSpeedProfile(levels[:, 0], levels[:, 1]),
        source_depth_m,
        receiver_depth_m,
        range_m,
        depth_m,
        frequency_hz,
        _bottom(bottom),
        surface_rms_m,
        absorption_db_km,
        within_db,
        most,
    )
    return Arrivals(
        time_s=np.array([one.time_s for one in found], float),
        level_db=np.array([one.level_db for one in found], float),
        phase_rad=np.array([one.phase_rad for one in found], float),
        launch_rad=np.array([one.launch_dip_rad for one in found], float),
        arrival_rad=np.array([one.arrival_dip_rad for one in found], float),
        length_m=np.array([one.length_m for one in found], float),
        surface_bounces=np.array([one.surface_bounces for one in found], np.int64),
        bottom_bounces=np.array([one.bottom_bounces for one in found], np.int64),
        turns=np.array([one.turns for one in found], np.int64),
    )


def _check_at_least(name: str, value: float, least: float, unit: str = "") -> None:
    if not (math.isfinite(value) and value >= least):
        raise ValueError(f"{name} = {value:g} {unit}".rstrip() + f": must be at least {least:g} {unit}".rstrip())


def _bottom(bottom: str | Sequence[float] | None) -> tuple[float, float, float]:
    """Return the density and the speed of sound of the bottom, relative to water, and its attenuation."""
    if bottom is None:
        return BOTTOMS["sand"]  # never reached by any ray
    if isinstance(bottom, str):
        if bottom not in BOTTOMS:
            raise ValueError(f"bottom = {bottom!r}: must be one of {', '.join(BOTTOMS)}, or three numbers")
        return BOTTOMS[bottom]
    rule = "density [0.5, 10] and speed [0.5, 5] relative to water, and attenuation [0, 10] dB per wavelength"
    try:
        density, speed, attenuation = (float(value) for value in bottom)
    except (TypeError, ValueError):
        raise ValueError(f"bottom = {bottom!r:.60}: must be three numbers, {rule}") from None
    if not (0.5 <= density <= 10.0 and 0.5 <= speed <= 5.0 and 0.0 <= attenuation <= 10.0):
        raise ValueError(f"bottom = {tuple(bottom)}: must be {rule}")
    return density, speed, attenuation


SEABEDS: tuple[str, ...] = tuple(_core.seabeds())
"""The names of the seabeds, from rough rock to clay."""


def seabed_backscatter_db(
    seabed: str, grazing_rad: ArrayLike, frequency_hz: float, sound_speed_m_s: float = 1500.0
) -> NDArray[np.float64]:
    """Return the backscattering strength [dB per square metre] of a seabed at each of an array of grazing angles.

    seabed: one of SEABEDS. The model is that of APL-UW 1994, TR 9407, ch. IV, valid from 10 to 100 kHz and for 1400 to
    1600 m/s; see cpp/uwsim/acoustics/seabed.h. Raises ValueError outside these ranges, for angles outside [0, pi/2],
    and for an unknown name.
    """
    angles = np.asarray(grazing_rad, np.float64)
    levels_db = _core.seabed_backscatter_db(seabed, angles.ravel(), frequency_hz, sound_speed_m_s)
    return np.asarray(levels_db, np.float64).reshape(angles.shape)
