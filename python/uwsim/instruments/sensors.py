"""A vehicle's sensors and their samples."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar, cast, overload

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.named import Named
from uwsim.base.sealed import Attached
from uwsim.instruments.acoustics.pinger_sound import PingerSound
from uwsim.instruments.derived import Derivation, reading_class
from uwsim.instruments.distortion import Distortion
from uwsim.instruments.readings import (
    READINGS,
    AccelerationReading,
    AdcpReading,
    CtdReading,
    DvlReading,
    GpsReading,
    ImuReading,
    InsReading,
    PositionReading,
    UsblReading,
    VelocityReading,
)
from uwsim.instruments.sample_stream import Samples, SampleSource, SampleStream
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.sensor_kind import DerivedKind, sensor_kind

R = TypeVar("R")
"""A sensor's reading: a float in its unit, or one of the classes of uwsim.instruments.readings."""


ScalarKind = Literal["depth", "pressure", "temperature", "altitude", "proximity", "compass", "gyrocompass", "contact"]


@dataclass(frozen=True, eq=False)
class Sample(Generic[R]):
    """A sensor value as returned by `Sensor.read`, with the time of its measurement and whether it is valid."""

    value: R
    stamp_ns: int
    valid: bool

    @property
    def stamp_s(self) -> float:
        """Simulated time of the measurement in seconds."""
        return self.stamp_ns * 1e-9


class Sensor(Attached, Generic[R]):
    """A sensor whose noise comes from its own seeded random stream.

    Repeated reads at one time return the same sample; neither reads nor other sensors affect later samples.

    kind: see uwsim.scenario.spec.sensor_kind. meaning: a description of the measured quantities. on: whether it is
    powered; see Simulator.parameters. period_s: time between samples. spec: its mounting, parameters and errors. Axes:
    x forward, y left, z up, unless the vehicle's YAML file rotates the sensor.

    - imu: angular_velocity_rad_s (3,), linear_acceleration_m_s2 (3,) (specific force), orientation_xyzw (4,)
    - velocity: linear_velocity_m_s (3,) over ground, angular_velocity_rad_s (3,)
    - acceleration: linear_acceleration_m_s2 (3,) without gravity, angular_acceleration_rad_s2 (3,)
    - depth [m], from pressure with a nominal density; pressure [Pa, absolute]; temperature [deg C]
    - altitude [m, inf if out of range]; proximity [m, the maximum range if nothing is nearer]
    - dvl: velocity_m_s (3,), beam_ranges_m (4,) (inf: lost), beam_velocities_m_s (4,), bottom_lock (1 or 0)
    - usbl: position_m (3,) from the station along east, north and up, range_m, azimuth_rad (from east to north),
      elevation_rad (up is positive), station_world_m (3,), where the station takes itself to be
    - gps: position_m (3,), velocity_m_s (3,), fix (1 or 0); ins: position_m (3,), velocity_m_s (3,), orientation_xyzw
      (4,), all in world axes
    - adcp: velocity_m_s (3,), through the water, and cell_velocities_m_s (96,), water_lock (1 or 0)
    - compass [rad, clockwise from magnetic north, in [0, 2 pi)]; gyrocompass, the same from true north
    - contact: 1 while in contact, else 0
    """

    name: str
    kind: str
    meaning: str
    rate_hz: float | None
    latency_s: float
    period_s: float
    spec: _core.SensorSpec
    on: bool

    def __init__(
        self,
        simulation: _core.Simulation,
        vehicle: int,
        index: int,
        spec: _core.SensorSpec,
        step_s: float,
        mount: SensorMount,
        stream: str,
        seed: Callable[[], int],
        sound: PingerSound,
    ) -> None:
        """mount: as in the scenario. stream: "vehicle/sensor", for the noise of kinds in Python. seed: the run's.

        sound: the pingers', for kinds in Python that hear it.
        """
        self._step_s = step_s
        self._source = SampleSource(
            lambda: self._distorted(*simulation.take_samples(vehicle, index)),
            lambda from_ns: simulation.watch_sensor(vehicle, index, from_ns),
        )
        self._simulation = simulation
        self._vehicle = vehicle
        self._index = index
        kind = sensor_kind(mount.kind)
        self._derived = Derivation(kind, mount, stream, 0.0, seed, sound) if isinstance(kind, DerivedKind) else None
        self._source_fields = _core.sensor_kind(spec.kind).fields
        self._reading = reading_class(kind) if isinstance(kind, DerivedKind) else READINGS.get(kind.name)
        self._scalar = next(iter(kind.fields)) if self._reading is None else None
        self._fields = kind.fields
        self._units = {field: unit for field, (_, unit) in kind.fields.items()}
        self.name = spec.name
        self.kind = kind.name
        self.meaning = kind.meaning
        self._distortion: Distortion | None = None
        self.change(spec, mount)

    @property
    def distortion(self) -> Distortion | None:
        """The distortion that a fault applies to the readings, or None; see Simulator.faults."""
        return self._distortion

    def distort(self, distortion: Distortion | None) -> None:
        """Distort readings from now on; None stops the distortion.

        Faults call this. Raises ValueError if the distortion does not fit the sensor's fields.
        """
        if distortion is not None:
            distortion.check(self._fields)
        self._source.settle()
        self._distortion = distortion

    def stick(self) -> None:
        """Repeat the current reading from now on. Faults call this."""
        self.distort(Distortion.stuck_at(self._quantities(self._newest(True), True)))

    def add_bias(self, bias: float, field: str | None) -> None:
        """Add a constant to each component of a field, or of all fields, from now on. Faults call this."""
        self.distort(Distortion(field=field, bias=bias))

    def _distorted(self, stamps_ns: Any, arrivals_ns: Any, readings: Any, valid: Any) -> tuple[Any, Any, Any, Any]:
        """Return samples as the sensor reports them: distorted by a fault, or invalid while the sensor is off."""
        if self._derived is not None:
            readings = self._derived.rows(stamps_ns, readings, self._source_fields)
            valid = valid & ~np.isnan(readings).any(axis=1)
        if self._distortion is not None:
            readings = self._distortion.of_rows(readings, self._fields)
        return stamps_ns, arrivals_ns, readings, valid if self.on else np.zeros_like(valid)

    def change(self, spec: _core.SensorSpec, mount: SensorMount) -> None:
        """Replace the sensor's errors and timing. Simulator.parameters calls this."""
        on = mount.on
        if on != self.__dict__.get("on", on) or (self._derived is not None and mount != self._derived.mount):
            self._source.settle()
        period_s = max(1.0 / spec.rate_hz, self._step_s) if spec.rate_hz else self._step_s
        self.__dict__ |= {
            "rate_hz": spec.rate_hz or None, "latency_s": spec.latency_s, "period_s": period_s, "spec": spec, "on": on,
        }  # fmt: skip
        if self._derived is not None:
            self._derived = replace(self._derived, mount=mount, rate_hz=1.0 / period_s)

    @property
    def unit(self) -> str | dict[str, str]:
        """The unit of the value, such as "m", or for several quantities a dict such as {"velocity_m_s": "m/s"}."""
        return self._units if self._scalar is None else self._units[self._scalar]

    @property
    def numbers(self) -> dict[str, str]:
        """The unit of each number of a reading, by "sensor NAME", or "sensor NAME QUANTITY" with " 0", " 1" ... ."""
        if self._scalar is not None:
            return {f"sensor {self.name}": self._units[self._scalar]}
        return {
            f"sensor {self.name} {field}{part}": unit
            for field, (width, unit) in self._fields.items()
            for part in ([""] if width == 1 else [f" {k}" for k in range(width)])
        }

    def flat(self, reading: R) -> list[float]:
        """Return the numbers of a reading, in the order of `numbers`."""
        if self._scalar is not None:
            return [cast(float, reading)]
        found: list[float] = np.hstack([getattr(reading, field) for field in self._fields]).tolist()
        return found

    def read(self, *, noise: bool = True) -> R:
        """Return the newest sample that has arrived: a float in `unit`, or several values (`readings.py`).

        Between samples, the last sample is returned; dropped samples are skipped. Before the first sample arrives, the
        current value is measured. `sample` distinguishes these cases. noise=False returns the current true value,
        without errors, rate, latency or drop-outs. A sensor that is off returns NaN.
        """
        return self._value(self._newest(noise), noise)

    def sample(self, *, noise: bool = True) -> Sample[R]:
        """Return the value of `read` with its time and validity.

        A sample is invalid if there is no measurement (a DVL without bottom lock, a distance out of range, no USBL
        fix), if the newest sample was dropped, if none has arrived yet, or if the sensor is off.
        """
        reading = self._newest(noise)
        value = self._value(reading, noise)
        measured = self._derived is None or not np.isnan(self.flat(value)).any()
        return Sample(value, reading.stamp_ns, reading.valid and self.on and measured)

    def stream(self, from_ns: int | None = None) -> SampleStream:
        """Return a stream of the sensor's future samples, each delivered once, on arrival, without dropped samples.

        from_ns: the earliest measurement time; by default, any time from now on. At most 1,000,000 samples are kept
        until they are taken; the stream's `dropped` counts older ones. The stream ends when the simulator is reset or
        restored. Samples of a sensor that is off are invalid.
        """
        return self._source.stream(self._simulation.time_ns + 1 if from_ns is None else from_ns)

    @property
    def is_plain(self) -> bool:
        """True if its readings are those of the core: it is on, no fault distorts them, and its kind is the core's."""
        return self.on and self._distortion is None and self._derived is None

    def _columns(self, readings: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Return the columns of each quantity, (n, width), from those of all, (n, sum of widths)."""
        return np.split(readings, np.cumsum([width for width, _ in self._fields.values()])[:-1], axis=1)

    def reading_of(self, readings: NDArray[np.float64]) -> Any:
        """Return a reading whose quantities are columns, (n,) or (n, width), from their numbers side by side."""
        columns = [column[:, 0] if column.shape[1] == 1 else column for column in self._columns(readings)]
        return columns[0] if self._reading is None else self._reading(**dict(zip(self._fields, columns, strict=True)))

    def samples_of(self, rows: Samples) -> list[Sample[R]]:
        """Return a stream's samples one by one."""
        columns = self._columns(rows.readings)
        scalars = [column.shape[1] == 1 for column in columns]
        found = []
        for k in range(len(rows)):
            values: dict[str, Any] = {
                name: column[k, 0] if is_scalar else column[k]
                for name, column, is_scalar in zip(self._fields, columns, scalars, strict=True)
            }
            value = self._reading(**values) if self._reading is not None else float(values[str(self._scalar)])
            found.append(Sample(cast(R, value), int(rows.stamps_ns[k]), bool(rows.valid[k])))
        return found

    @property
    def source(self) -> SampleSource:
        """The source of all its streams. Simulator uses it."""
        return self._source

    def end_streams(self) -> None:
        """End all streams because time is going back. Simulator calls this."""
        self._source.close()

    @property
    def averaging_s(self) -> float:
        """The period before a sample over which accelerations are averaged: the simulator step in seconds."""
        return self._step_s

    @property
    def time_ns(self) -> int:
        """Simulated time in nanoseconds."""
        return self._simulation.time_ns

    def _newest(self, noise: bool) -> _core.SensorReading:
        return self._simulation.read_sensor(self._vehicle, self._index, noise)

    def _quantities(self, reading: _core.SensorReading, noise: bool) -> dict[str, Any]:
        """Return the quantities of this sensor's kind by name."""
        if self._derived is None:
            return reading.values
        return self._derived.reading(reading.values, reading.stamp_ns, noise=noise)

    def _value(self, reading: _core.SensorReading, noise: bool) -> R:
        values = self._quantities(reading, noise)
        values = values if self.on else {field: value * math.nan for field, value in values.items()}
        if noise and self._distortion is not None and self.on:
            values = self._distortion.of(values)
        if self._reading is not None:
            return cast(R, self._reading(**values))
        assert self._scalar is not None
        return cast(R, float(values[self._scalar]))

    def __repr__(self) -> str:
        rate = f"{self.rate_hz:g} Hz" if self.rate_hz else "read at any time"
        return f"<Sensor '{self.name}' ({self.kind}, {rate}{'' if self.on else ', off'}): {self.meaning}>"


class Sensors(Named[Sensor[Any]]):
    """A vehicle's sensors, keyed by name.

    A sensor named after a kind is of that kind, so its name determines the type of its readings.
    """

    if TYPE_CHECKING:

        @overload
        def __getitem__(self, name: Literal["imu"], /) -> Sensor[ImuReading]: ...
        @overload
        def __getitem__(self, name: Literal["position"], /) -> Sensor[PositionReading]: ...
        @overload
        def __getitem__(self, name: Literal["velocity"], /) -> Sensor[VelocityReading]: ...
        @overload
        def __getitem__(self, name: Literal["acceleration"], /) -> Sensor[AccelerationReading]: ...
        @overload
        def __getitem__(self, name: Literal["dvl"], /) -> Sensor[DvlReading]: ...
        @overload
        def __getitem__(self, name: Literal["usbl"], /) -> Sensor[UsblReading]: ...
        @overload
        def __getitem__(self, name: Literal["ctd"], /) -> Sensor[CtdReading]: ...
        @overload
        def __getitem__(self, name: Literal["gps"], /) -> Sensor[GpsReading]: ...
        @overload
        def __getitem__(self, name: Literal["ins"], /) -> Sensor[InsReading]: ...
        @overload
        def __getitem__(self, name: Literal["adcp"], /) -> Sensor[AdcpReading]: ...
        @overload
        def __getitem__(self, name: ScalarKind, /) -> Sensor[float]: ...
        @overload
        def __getitem__(self, name: str, /) -> Sensor[Any]: ...
        def __getitem__(self, name: str, /) -> Sensor[Any]: ...
