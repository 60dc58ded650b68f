"""A vehicle's sensor as the core's SensorSpec."""

from __future__ import annotations

import math

from uwsim import _core
from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.scenario.build.magnetic_field import compass_field
from uwsim.scenario.spec.earth import Earth
from uwsim.scenario.spec.sensor import OWN_NOISE, Noise, SensorMount
from uwsim.scenario.spec.sensor_kind import DerivedKind, sensor_kind


def sensor_spec(name: str, sensor: SensorMount, earth: Earth | None = None) -> _core.SensorSpec:
    """Return the sensor's spec, including the errors of each channel. Raises ScenarioError or ValueError.

    For a kind in Python, this is an exact sensor of its source. earth: place of the world, whose field compasses have.
    """
    overall = sensor.noise or Noise(std=sensor.noise_std or 0.0)
    kind = sensor_kind(sensor.kind)
    is_derived = isinstance(kind, DerivedKind)
    source = kind.source if isinstance(kind, DerivedKind) else sensor.kind
    given = {} if is_derived else {key: list(values) for key, values in sensor.parameters.items()}
    return _core.SensorSpec(
        name,
        source,
        sensor.position_m,
        of_yaw_pitch_roll_deg(sensor.yaw_pitch_roll_deg),
        parameters=_of_place(source, earth) | given,
        noise={
            channel: _noise_spec(sensor.channels.get(channel, Noise() if channel in OWN_NOISE else overall))
            for channel in (() if is_derived else kind.channels)
        },
        rate_hz=sensor.rate_hz or 0.0,
        latency_s=sensor.latency_s,
        drop_out=sensor.drop_out,
    )


def _of_place(source: str, earth: Earth | None) -> dict[str, list[float]]:
    """Return the parameters of a kind of sensor that the world's place implies. Raises ScenarioError."""
    if source == "compass":
        return compass_field(earth)
    return {"latitude_deg": [earth.latitude_deg]} if source == "gyrocompass" and earth is not None else {}


def measures_temperature(sensor: SensorMount) -> bool:
    """Return whether a sensor, or the source of one in Python, measures the water's temperature."""
    kind = sensor_kind(sensor.kind)
    return (kind.source if isinstance(kind, DerivedKind) else sensor.kind) in ("temperature", "ctd")


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
