"""A sensor's noise parameters in the format that the filter expects; the truth is not used."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.navigation.estimation.protocols import InstrumentLike

LEAST_STD = {
    "beam_velocity": 1e-3, "depth": 1e-3, "pressure": 10.0, "heading": 1e-4, "orientation": 1e-4,
    "horizontal": 5e-3, "vertical": 5e-3, "velocity": 5e-3,
}  # fmt: skip
"""The assumed error of an exact sensor, in its unit, since the filter's equations are not exact either."""
FLICKER_TIME_S = 100.0
"""Correlation time of the filter's drifting bias for a sensor that has flicker noise but no drifting bias of its
own.
"""


def noise_of(sensor: InstrumentLike, channel: str) -> _core.NoiseSpec:
    """Return the error parameters of a channel."""
    return sensor.spec.noise.get(channel) or _core.NoiseSpec()


def white_std(sensor: InstrumentLike, channel: str) -> float:
    """Return the standard deviation of the white noise in a sample, including rounding, quantum / sqrt(12) [u]."""
    noise = noise_of(sensor, channel)
    parts = noise.std, noise.density / math.sqrt(sensor.period_s), noise.quantum / math.sqrt(12.0)
    return max(math.hypot(*parts), LEAST_STD.get(channel, 0.0))


def rounding_step(sensor: InstrumentLike, channel: str) -> float:
    """Return the step to which a channel is rounded [u], or 0 if white noise varies its readings by steps anyway."""
    noise = noise_of(sensor, channel)
    white = math.hypot(noise.std, noise.density / math.sqrt(sensor.period_s))
    return noise.quantum if white < 0.5 * noise.quantum else 0.0


def limit(sensor: InstrumentLike, channel: str) -> float:
    """Return the largest magnitude that a channel can report [u], or inf if there is no limit."""
    noise = noise_of(sensor, channel)
    return min(abs(noise.limit_low), abs(noise.limit_high))


def bias_model(
    sensor: InstrumentLike, channel: str, unit: float = 1.0, *, more_std: float = 0.0, walk: float = 0.0
) -> _core.BiasModel:
    """Return the bias model of a channel, scaled by `unit`.

    more_std, walk: of an error of the same kind that is not the instrument's: a constant [u], a random walk
    [u/sqrt(s)].
    """
    noise = noise_of(sensor, channel)
    drift_std = math.hypot(noise.bias_std, noise.flicker_std)
    time_s = noise.bias_time_s if noise.bias_std > 0 else FLICKER_TIME_S
    return _core.BiasModel(
        turn_on_std=math.hypot(noise.turn_on_std * unit, more_std),
        drift_std=drift_std * unit,
        drift_time_s=time_s if drift_std > 0 else 0.0,
        walk=math.hypot(noise.walk * unit, walk),
    )


def rms(values: NDArray[np.float64]) -> float:
    """Return the root of the mean square."""
    return math.sqrt(np.mean(np.square(values)))


def matrix_stds(imu: InstrumentLike) -> dict[str, tuple[float, float]]:
    """Return the rms of the elements on and off the diagonal of an IMU's error matrices, by their names in the filter.

    Of these errors, as of a compass's own field, only the strength is known.
    """
    stated = {name: np.asarray(values) for name, values in imu.spec.parameters.items()}
    by_force = stated["gyro_g_sensitivity"]
    matrices = {
        "gyroscope_scale": (stated["gyro_scale"], stated["gyro_misalignment_rad"]),
        "gyroscope_by_force": (by_force[::4], np.delete(by_force, [0, 4, 8])),
        "accelerometer_scale": (stated["accelerometer_scale"], stated["accelerometer_misalignment_rad"]),
    }
    return {name: (rms(on), rms(off)) for name, (on, off) in matrices.items()}


def whole_std(sensor: InstrumentLike, channel: str) -> float:
    """Return the standard deviation of a sample, including biases but not random walks."""
    noise = noise_of(sensor, channel)
    return math.hypot(white_std(sensor, channel), noise.turn_on_std, noise.bias_std, noise.flicker_std)
