"""Variances of sensor readings, derived from the noise parameters, for the covariance fields of messages.

The variance of a reading is the sum of the variances of independent errors: white noise (std, or density x sqrt(rate)),
turn-on bias, Gauss-Markov bias and flicker noise in their stationary state, the random walk so far, and rounding,
quantum^2 / 12 (uniform over one step). Limits and lost samples are not included.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.spec.sensor import Noise, SensorMount

UNKNOWN = -1.0  # REP 145 and marine_acoustic_msgs: the first element of an unknown covariance


def variance(mount: SensorMount, channel: str, rate_hz: float, time_s: float) -> float:
    """Return the error variance of a channel [unit^2] at a time since the start, or 0 for an exact sensor.

    rate_hz: the sensor's sampling rate.
    """
    noise = _noise(mount, channel)
    white = noise.std**2 + noise.density**2 * rate_hz
    bias = noise.turn_on_std**2 + noise.bias_std**2 + _flicker_std(noise.instability) ** 2
    return white + (bias + noise.walk**2 * max(time_s, 0.0)) + noise.quantum**2 / 12.0


def is_steady(mount: SensorMount, channel: str) -> bool:
    """Return whether a channel's variance is the same at all times."""
    return _noise(mount, channel).walk == 0.0


def _noise(mount: SensorMount, channel: str) -> Noise:
    return mount.channels.get(channel) or mount.noise or _white(mount.noise_std or 0.0)


@lru_cache(256)
def _white(std: float) -> Noise:
    return Noise(std=std)


@lru_cache(256)
def _flicker_std(instability: float) -> float:
    return _core.NoiseSpec(instability=instability).flicker_std


def isotropic(value: float) -> NDArray[np.float64]:
    """Return the row-major covariance (9,), read-only, of three axes with equal, independent errors."""
    return independent(value, value, value)


@lru_cache(256)
def independent(*values: float) -> NDArray[np.float64]:
    """Return the row-major covariance (n * n,), read-only, of independent errors with these variances."""
    found = np.diag(values).ravel()
    found.setflags(write=False)
    return found


def of_velocity(beams: NDArray[np.float64], value: float) -> NDArray[np.float64]:
    """Return the row-major covariance (9,) of a velocity obtained by a least-squares fit to beam velocities.

    beams: unit vectors (n, 3). value: the variance of each beam velocity. With fewer than three directions, the
    covariance is unknown.
    """
    shape = _fit_covariance(beams.shape[0], beams.tobytes())
    return np.full(9, UNKNOWN) if shape is None else value * shape


@lru_cache(64)
def _fit_covariance(count: int, beams: bytes) -> NDArray[np.float64] | None:
    """Return the covariance (9,) for beams of variance 1, as a sensor's geometry changes seldom; None if unknown."""
    directions = np.frombuffer(beams).reshape(count, 3)
    if np.linalg.matrix_rank(directions) < 3:
        return None
    return np.asarray(np.linalg.inv(directions.T @ directions), np.float64).ravel()
