"""Backscatter of the generic seabeds of APL-UW TR 9407 by grazing angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core

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
