"""What a vehicle carries: sensors and sonars."""

from __future__ import annotations

from types import SimpleNamespace

from uwsim import _core


class Sensor:
    """A sensor. Its noise is seeded and its own: however often it is read at one time, it is the same sample."""

    def __init__(self, simulation: _core.Simulation, vehicle: int, index: int, name: str, kind: str) -> None:
        self._simulation = simulation
        self._vehicle = vehicle
        self._index = index
        self.name = name
        self.kind = kind

    def read(self, *, noise: bool = True) -> float | SimpleNamespace:
        """A float in the sensor's SI unit, or a namespace of arrays for a sensor of several quantities (imu).

        imu: angular_velocity_rad_s (3,), linear_acceleration_m_s2 (3,) (specific force), orientation_xyzw (4,).
        depth [m], pressure [Pa, absolute], temperature [deg C], altitude [m, inf out of range], proximity [m, its
        range where nothing is nearer]. noise=False gives the true value.
        """
        reading = self._simulation.read_sensor(self._vehicle, self._index, noise)
        if len(reading) == 1:
            return float(next(iter(reading.values())))
        return SimpleNamespace(**reading)


class Sonar:
    """A multibeam head that looks forward and tilts."""

    def __init__(self, simulation: _core.Simulation, vehicle: int, index: int, spec: _core.SonarSpec) -> None:
        self._simulation = simulation
        self._vehicle = vehicle
        self._index = index
        self.name: str = spec.name
        self.model = _core.multibeam_model(spec.model)
        self._last: tuple[int, _core.Ping] | None = None

    def aim(self, elevation_rad: float) -> None:
        """Turn the head: positive is up, 0 straight ahead. Raises ValueError beyond +-pi/2."""
        self._simulation.aim(self._vehicle, self._index, elevation_rad)

    def ping(self) -> _core.Ping:
        """One ping from where the vehicle is now; see _core.Ping for its arrays. At one time it is always the same."""
        version = self._simulation.version
        if self._last is None or self._last[0] != version:
            self._last = version, self._simulation.ping(self._vehicle, self._index)
        return self._last[1]
