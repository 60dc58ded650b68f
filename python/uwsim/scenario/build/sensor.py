"""A vehicle's sensor as the core's SensorSpec."""

from __future__ import annotations

import math

from uwsim import _core
from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.scenario.spec.sensor import Noise, SensorMount
from uwsim.scenario.spec.sensor_kind import DerivedKind, sensor_kind


def sensor_spec(name: str, sensor: SensorMount) -> _core.SensorSpec:
    """Return the sensor's spec, including the errors of each channel. Raises ValueError.

    For a kind in Python, this is an exact sensor of its source.
    """
    overall = sensor.noise or Noise(std=sensor.noise_std or 0.0)
    kind = sensor_kind(sensor.kind)
    is_derived = isinstance(kind, DerivedKind)
    return _core.SensorSpec(
        name,
        kind.source if isinstance(kind, DerivedKind) else sensor.kind,
        sensor.position_m,
        of_yaw_pitch_roll_deg(sensor.yaw_pitch_roll_deg),
        parameters={} if is_derived else {key: list(values) for key, values in sensor.parameters.items()},
        noise={
            channel: _noise_spec(sensor.channels.get(channel, overall))
            for channel in (() if is_derived else kind.channels)
        },
        rate_hz=sensor.rate_hz or 0.0,
        latency_s=sensor.latency_s,
        drop_out=sensor.drop_out,
    )


def _noise_spec(noise: Noise) -> _core.NoiseSpec:
    low, high = noise.limits or (-math.inf, math.inf)
    return _core.NoiseSpec(
        std=noise.std,
        density=noise.density,
        turn_on_std=noise.turn_on_std,
        bias_std=noise.bias_std,
        bias_time_s=noise.bias_time_s or 0.0,
        walk=noise.walk,
        instability=noise.instability,
        quantum=noise.quantum,
        limit_low=low,
        limit_high=high,
    )
