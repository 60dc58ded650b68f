"""Readings from sensors that measure several quantities: one class per kind, with the same fields as in the core."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats


@dataclass(frozen=True, eq=False, repr=False)
class Reading:
    """Quantities that a sensor measured at one time; see Sensor.unit for their units."""

    def to_dict(self) -> dict[str, Any]:
        """Return the quantities by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __repr__(self) -> str:
        parts = (
            f"{name}={np.array2string(np.asarray(value), precision=4, suppress_small=True, separator=', ')}"
            for name, value in self.to_dict().items()
        )
        return f"{type(self).__name__}({', '.join(parts)})"


@dataclass(frozen=True, eq=False, repr=False)
class ImuReading(Reading):
    """The fields of sensor_msgs/Imu, in the sensor's axes.

    angular_velocity_rad_s: (3,). linear_acceleration_m_s2: (3,), specific force, which points up at rest.
    orientation_xyzw: (4,), world from sensor.
    """

    angular_velocity_rad_s: Floats
    linear_acceleration_m_s2: Floats
    orientation_xyzw: Floats


@dataclass(frozen=True, eq=False, repr=False)
class PositionReading(Reading):
    """Position in the world, position_m (3,), along east, north and up."""

    position_m: Floats


@dataclass(frozen=True, eq=False, repr=False)
class VelocityReading(Reading):
    """Velocity over ground, linear_velocity_m_s (3,), and angular_velocity_rad_s (3,), in sensor axes."""

    linear_velocity_m_s: Floats
    angular_velocity_rad_s: Floats


@dataclass(frozen=True, eq=False, repr=False)
class AccelerationReading(Reading):
    """Linear and angular acceleration, (3,) each, in sensor axes; the linear acceleration excludes gravity."""

    linear_acceleration_m_s2: Floats
    angular_acceleration_rad_s2: Floats


@dataclass(frozen=True, eq=False, repr=False)
class DvlReading(Reading):
    """Velocity over the bottom, velocity_m_s (3,), in sensor axes, and the beam measurements.

    beam_ranges_m: (4,), inf for a lost beam. beam_velocities_m_s: (4,), along each beam. bottom_lock: 1 or 0.
    """

    velocity_m_s: Floats
    beam_ranges_m: Floats
    beam_velocities_m_s: Floats
    bottom_lock: float


@dataclass(frozen=True, eq=False, repr=False)
class UsblReading(Reading):
    """Position relative to the station, position_m (3,), along east, north and up; its range, range_m; and two angles.

    azimuth_rad: measured from east to north. elevation_rad: positive up. station_world_m (3,): where the station takes
    itself to be, at the time of the ping.
    """

    position_m: Floats
    range_m: float
    azimuth_rad: float
    elevation_rad: float
    station_world_m: Floats


@dataclass(frozen=True, eq=False, repr=False)
class CtdReading(Reading):
    """Conductivity, temperature and gauge pressure of the water, and the practical salinity that follows from them."""

    conductivity_ms_cm: float
    temperature_deg_c: float
    pressure_dbar: float
    salinity_psu: float


@dataclass(frozen=True, eq=False, repr=False)
class GpsReading(Reading):
    """Position and velocity of the antenna, (3,) each, in world axes, NaN without a fix; fix: 1 or 0."""

    position_m: Floats
    velocity_m_s: Floats
    fix: float


@dataclass(frozen=True, eq=False, repr=False)
class InsReading(Reading):
    """Position and velocity, (3,) each, in world axes, and the attitude, orientation_xyzw (4,), as an INS has them."""

    position_m: Floats
    velocity_m_s: Floats
    orientation_xyzw: Floats


@dataclass(frozen=True, eq=False, repr=False)
class AdcpReading(Reading):
    """Velocity through the water, velocity_m_s (3,), in sensor axes: the mean of the reference layer.

    cell_velocities_m_s: (96,), x, y and z of the first cell, then of the second, to the 32nd; NaN for lost cells, and
    for those that the instrument does not have. water_lock: 1 or 0.
    """

    velocity_m_s: Floats
    cell_velocities_m_s: Floats
    water_lock: float


READINGS: dict[str, type[Reading]] = {
    "imu": ImuReading,
    "position": PositionReading,
    "velocity": VelocityReading,
    "acceleration": AccelerationReading,
    "dvl": DvlReading,
    "usbl": UsblReading,
    "ctd": CtdReading,
    "gps": GpsReading,
    "ins": InsReading,
    "adcp": AdcpReading,
}
"""Classes of readings by the sensor's kind. Kinds that are not listed measure a single value."""
