"""What a vehicle carries: sensors and sonars."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from uwsim import _core

Value = float | SimpleNamespace
"""A scalar in the sensor's unit, or a namespace of floats and (n,) arrays for a sensor of several quantities."""


@dataclass(frozen=True, eq=False)
class Sample:
    """A sensor's value as `Sensor.read` gives it, when it was taken (simulated time), and whether it can be trusted."""

    value: Value
    stamp_ns: int
    valid: bool

    @property
    def stamp_s(self) -> float:
        """When it was taken, seconds."""
        return self.stamp_ns * 1e-9


class Sensor:
    """A sensor with noise from its own seeded stream.

    However often it is read at one time, it is the same sample; neither reading nor other sensors change later ones.

    kind, one of _core.sensor_kinds(); meaning: what it measures, in words. Frames: x forward, y left, z up unless the
    vehicle's YAML turns the sensor.

    - imu: angular_velocity_rad_s (3,), linear_acceleration_m_s2 (3,) (specific force), orientation_xyzw (4,)
    - velocity: linear_velocity_m_s (3,) over ground, angular_velocity_rad_s (3,)
    - acceleration: linear_acceleration_m_s2 (3,) without gravity, angular_acceleration_rad_s2 (3,)
    - depth [m], from pressure with a nominal density; pressure [Pa, absolute]; temperature [deg C]
    - altitude [m, inf out of range]; proximity [m, its range where nothing is nearer]
    - dvl: velocity_m_s (3,), beam_ranges_m (4,) (inf: lost), beam_velocities_m_s (4,), bottom_lock (1 or 0)
    - usbl: position_m (3,) from the station along east, north and up, range_m, azimuth_rad (from east to north),
      elevation_rad (up is positive)
    - compass [rad, clockwise from magnetic north, in [0, 2 pi)]; contact: 1 while touching, else 0
    """

    def __init__(self, simulation: _core.Simulation, vehicle: int, index: int, spec: _core.SensorSpec) -> None:
        self._simulation = simulation
        self._vehicle = vehicle
        self._index = index
        kind = _core.sensor_kind(spec.kind)
        self._scalar = next(iter(kind.fields)) if _is_scalar(kind) else None
        self._units = {field: unit for field, (_, unit) in kind.fields.items()}
        self.name: str = spec.name
        self.kind: str = kind.name
        self.meaning: str = kind.meaning
        self.rate_hz: float | None = spec.rate_hz or None
        self.latency_s: float = spec.latency_s

    @property
    def unit(self) -> str | dict[str, str]:
        """Of the value, such as "m"; by quantity for a sensor of several, such as {"velocity_m_s": "m/s"}."""
        return self._units if self._scalar is None else self._units[self._scalar]

    def read(self, *, noise: bool = True) -> Value:
        """The newest sample that has arrived: a float in `unit`, or a namespace for a sensor of several quantities.

        Between samples it is the last one; while samples drop out, the last that came through; before the first has
        arrived, the present. `sample` tells these apart. noise=False gives the present true value, without errors,
        rate, latency and drop-outs.
        """
        return self._value(self._simulation.read_sensor(self._vehicle, self._index, noise))

    def sample(self, *, noise: bool = True) -> Sample:
        """What `read` gives, with its time and whether it is valid.

        Not valid: no measurement (a DVL without bottom lock, a range out of reach, no USBL fix), the newest sample was
        lost, or none has arrived yet.
        """
        reading = self._simulation.read_sensor(self._vehicle, self._index, noise)
        return Sample(self._value(reading), reading.stamp_ns, reading.valid)

    def _value(self, reading: _core.SensorReading) -> Value:
        if self._scalar is not None:
            return float(reading.values[self._scalar])
        return SimpleNamespace(**reading.values)


def _is_scalar(kind: _core.SensorKind) -> bool:
    return [width for width, _ in kind.fields.values()] == [1]


class Sonar:
    """A multibeam head that looks forward and tilts.

    mode: "geometry" (one exact ray a beam) or "physics" (echoes, with their errors; see _core.PhysicsPing).
    """

    def __init__(self, simulation: _core.Simulation, vehicle: int, index: int, spec: _core.SonarSpec) -> None:
        self._simulation = simulation
        self._vehicle = vehicle
        self._index = index
        self.name: str = spec.name
        self.model = spec.model
        self.mode: str = "physics" if simulation.in_physics_mode(vehicle, index) else "geometry"
        self._last: tuple[int, _core.Ping] | None = None

    def aim(self, elevation_rad: float) -> None:
        """Where the head is to point: positive is up, 0 straight ahead. Raises ValueError beyond +-pi/2.

        It turns there as simulated time passes, at the model's tilt rate; `elevation_rad` tells how far it has come.
        """
        self._simulation.aim(self._vehicle, self._index, elevation_rad)

    @property
    def elevation_rad(self) -> float:
        """Where the head points now; pings are taken from there."""
        return self._simulation.sonar_elevation_rad(self._vehicle, self._index)

    @property
    def ping_rate_max_hz(self) -> float:
        """At most so many pings a second, c / (2 range): sound must come back from the farthest before the next leaves.

        c at the head's present depth. `ping` itself does not hold to it, since it takes no time; a survey's clock does.
        """
        return self._simulation.sonar_ping_rate_max_hz(self._vehicle, self._index)

    def ping(self) -> _core.Ping:
        """One ping from where the vehicle is now; see _core.Ping for its arrays. At one time it is always the same.

        What lies above the water gives no echo. A head above the water or under the terrain hears nothing: no beam is
        valid, ranges are inf. A head inside an obstacle hears its walls from within. In physics mode a
        _core.PhysicsPing, which has the same arrays and more.
        """
        version = self._simulation.version
        if self._last is None or self._last[0] != version:
            self._last = version, self._taken()
        return self._last[1]

    def _taken(self) -> _core.Ping:
        if self.mode == "physics":
            return cast(_core.Ping, self._simulation.acoustic_ping(self._vehicle, self._index))
        return self._simulation.ping(self._vehicle, self._index)

    def ping_batch(self, world_from_body: NDArray[np.float64], threads: int | None = None) -> _core.PingBatch:
        """Pings from many places at once, as if the vehicle were there: (n, 4, 4) rigid transforms; it stays put.

        Arrays are (n, beams); see _core.PingBatch. In geometry mode, the head tilted as it is now. threads: how many
        to use, by default all; results do not depend on it. Raises ValueError.
        """
        return self._simulation.ping_batch(self._vehicle, self._index, world_from_body, threads)
