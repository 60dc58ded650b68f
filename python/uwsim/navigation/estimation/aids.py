"""The instruments that correct the filter, and how samples of each kind are prepared: the table AIDS."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.navigation.estimation.errors import bias_model, rounding_step, white_std, whole_std
from uwsim.navigation.estimation.protocols import InstrumentLike, SamplesLike

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

ATMOSPHERE_PA = 101_325.0
GHOST_STDS, GHOST_M = 5.0, 10.0
"""A fix that is this many standard deviations plus this distance above the water is that of a reflected ray; the
distance leaves room for docks above the water and for high waves.
"""
STATION = (6, 7, 8)
"""The columns of a USBL's reading with the station's place."""
SOUND_TIME_S = 600.0
"""Assumed: the time after which a vehicle has come to water of another speed of sound."""


@dataclass(frozen=True)
class Surroundings:
    """Known properties of a vehicle and its surroundings.

    imu_body_m (3,): the position of the IMU. density_kg_m3, compressibility_1_pa: of the water at its surface.
    wave_std_m, tide_std_m: standard deviations of the water's surface, as expected, about the tide and of the tide.
    column_std: standard deviation of the mean density of the water above, relative to the surface's. sound_m_s: the
    least and the largest speed of sound in the water, as expected.
    """

    imu_body_m: Floats
    gravity_m_s2: float
    density_kg_m3: float
    compressibility_1_pa: float
    wave_std_m: float
    tide_std_m: float
    column_std: float
    sound_m_s: tuple[float, float]

    @property
    def metre_pa(self) -> float:
        """The pressure of a metre of surface water."""
        return self.density_kg_m3 * self.gravity_m_s2

    def depth_m(self, gauge_pa: Floats) -> Floats:
        """Return the depth at which surface water, compressed by its own weight, has this pressure.

        The pressure without compression is p - p^2 / (2 K); see cpp/uwsim/world/sea_water.h.
        """
        return gauge_pa * (1.0 - 0.5 * self.compressibility_1_pa * gauge_pa) / self.metre_pa


class Aid(NamedTuple):
    """A kind of instrument that corrects the filter.

    add_to: registers the instrument with the filter; returns its index there. terms: returns the numbers of its errors
    in the filter's state by name, in their order. readings: returns a mask (n,) of usable samples, and their readings
    in the format that the filter expects.
    """

    add_to: Callable[[_core.NavigationFilter, InstrumentLike, Surroundings], int]
    terms: Callable[[InstrumentLike, Surroundings], dict[str, int]]
    readings: Callable[[InstrumentLike, SamplesLike, Surroundings], tuple[Floats, Floats]]


def existing(*biases: tuple[str, int, _core.BiasModel]) -> dict[str, int]:
    """Return the numbers of those biases that exist, by name. biases: name, number and model of each."""
    return {name: n for name, n, model in biases if model.exists}


def lever(sensor: InstrumentLike, around: Surroundings) -> Floats:
    """Return a sensor's position relative to the IMU, in body axes."""
    return np.asarray(sensor.spec.position_m) - around.imu_body_m


def body_from_sensor(sensor: InstrumentLike) -> Rotation:
    """Return a sensor's orientation on the body."""
    from scipy.spatial.transform import Rotation  # slow to import

    return Rotation.from_quat(sensor.spec.orientation_xyzw)


def _add_doppler(filter_: _core.NavigationFilter, sensor: InstrumentLike, around: Surroundings) -> int:
    figures = sensor.spec.parameters
    slant = math.radians(figures["beam_slant_deg"][0])
    azimuths = np.radians(figures["beam_azimuth_deg"][0]) + 0.5 * np.pi * np.arange(4)
    down = np.full(4, -math.cos(slant))
    beams = np.column_stack([math.sin(slant) * np.cos(azimuths), math.sin(slant) * np.sin(azimuths), down])
    return filter_.add_doppler(
        body_from_sensor(sensor).apply(beams),
        lever(sensor, around),
        white_std(sensor, "beam_velocity"),
        bias_model(sensor, "beam_velocity"),
        _doppler_scale(sensor, around),
        bias_model(sensor, "misalignment"),
    )


def _doppler_terms(sensor: InstrumentLike, around: Surroundings) -> dict[str, int]:
    scale, misalignment = _doppler_scale(sensor, around), bias_model(sensor, "misalignment")
    return {"beams": 4} | existing(("scale", 1, scale), ("misalignment", 3, misalignment))


def _doppler_scale(sensor: InstrumentLike, around: Surroundings) -> _core.BiasModel:
    """Return the error of the scale: the instrument's, and that of a set speed of sound in this water."""
    set_m_s = sensor.spec.parameters["sound_speed_m_s"][0]
    sound_std = max(abs(set_m_s / each - 1.0) for each in around.sound_m_s) if set_m_s > 0 else 0.0
    return bias_model(sensor, "scale", more_std=sound_std, walk=sound_std * math.sqrt(2.0 / SOUND_TIME_S))


def _doppler_readings(sensor: InstrumentLike, samples: SamplesLike, around: Surroundings) -> tuple[Floats, Floats]:
    ranges_m, velocities = samples.readings[:, 3:7], samples.readings[:, 7:11]
    good = np.isfinite(ranges_m)
    return good.any(axis=1), np.where(good, velocities, np.nan)


def _add_gauge(
    filter_: _core.NavigationFilter, sensor: InstrumentLike, around: Surroundings, channel: str, metres: float
) -> int:
    """Add a gauge of depth to the filter. metres: of surface water, to one unit of the channel."""
    return filter_.add_depth(
        lever(sensor, around),
        white_std(sensor, channel) * metres,
        bias_model(sensor, channel, metres),
        around.wave_std_m,
        around.tide_std_m,
        around.column_std,
    )


def _nominal_metre_pa(sensor: InstrumentLike, around: Surroundings) -> float:
    """Return the pressure of a metre of water of a depth sensor's nominal density, that of the surface by default."""
    nominal_kg_m3 = sensor.spec.parameters["density_kg_m3"][0]
    return nominal_kg_m3 * around.gravity_m_s2 if nominal_kg_m3 > 0 else around.metre_pa


def _add_compass(filter_: _core.NavigationFilter, sensor: InstrumentLike, around: Surroundings) -> int:
    figures = sensor.spec.parameters
    level_ut = figures["field_ut"][0] * math.cos(math.radians(figures["inclination_deg"][0]))
    return _add_heading(filter_, sensor, 1.0, math.hypot(*figures["hard_iron_ut"]) / math.sqrt(3.0) / level_ut)


def _add_heading(filter_: _core.NavigationFilter, sensor: InstrumentLike, secant: float, iron: float) -> int:
    """Add a compass of either kind. secant: by which its errors grow. iron: its hard-iron error, of the level field."""
    return filter_.add_heading(
        body_from_sensor(sensor).apply([1.0, 0.0, 0.0]),
        white_std(sensor, "heading") * secant,
        bias_model(sensor, "heading", secant),
        iron,
        north_rad(sensor),
    )


def north_rad(compass: InstrumentLike) -> float:
    """Return where a compass of either kind would point without errors, counterclockwise from east."""
    return 0.5 * math.pi - math.radians(compass.spec.parameters.get("declination_deg", [0.0])[0])


def _add_fixes(filter_: _core.NavigationFilter, sensor: InstrumentLike, around: Surroundings) -> int:
    return filter_.add_acoustic_fix(
        lever(sensor, around),
        white_std(sensor, "range"),
        white_std(sensor, "bearing"),
        rounding_step(sensor, "range"),
        sensor.period_s,
        range_bias=bias_model(sensor, "range"),
        scale=bias_model(sensor, "scale"),
        bearing_bias=bias_model(sensor, "bearing"),
        station_std=white_std(sensor, "station"),
        station_bias=bias_model(sensor, "station"),
    )


def _fix_terms(sensor: InstrumentLike, around: Surroundings) -> dict[str, int]:
    widths = {"range": 1, "scale": 1, "bearing": 2, "station": 3}
    return existing(*((channel, n, bias_model(sensor, channel)) for channel, n in widths.items()))


def _fixes(sensor: InstrumentLike, samples: SamplesLike, around: Surroundings) -> tuple[Floats, Floats]:
    fixes_m = samples.readings[:, [0, 1, 2, *STATION]]
    errors_m = whole_std(sensor, "bearing") * samples.readings[:, 3] + whole_std(sensor, "range")
    heights_m = fixes_m[:, 2] + fixes_m[:, 5]
    return samples.valid & (heights_m < GHOST_STDS * errors_m + GHOST_M), fixes_m


def _add_satellites(filter_: _core.NavigationFilter, sensor: InstrumentLike, around: Surroundings) -> int:
    return filter_.add_satellites(
        lever(sensor, around),
        white_std(sensor, "horizontal"),
        white_std(sensor, "vertical"),
        white_std(sensor, "velocity"),
        bias_model(sensor, "horizontal"),
        bias_model(sensor, "vertical"),
    )


def _orientations(sensor: InstrumentLike, samples: SamplesLike, around: Surroundings) -> tuple[Floats, Floats]:
    from scipy.spatial.transform import Rotation  # slow to import

    world_from_sensor = Rotation.from_quat(samples.readings[:, 6:10].reshape(-1, 4))
    return samples.valid, (world_from_sensor * body_from_sensor(sensor).inv()).as_quat()


GAUGE_TERMS = {"bias": 1, "waves": 2, "tide": 2, "density": 1}
AIDS: dict[str, Aid] = {
    # The beams of a DVL are processed separately, so that losing some does not affect the others.
    "dvl": Aid(_add_doppler, _doppler_terms, _doppler_readings),
    # A depth sensor divides the pressure by a nominal density; of a pressure sensor, the vehicle assumes it.
    "depth": Aid(
        lambda filter_, sensor, around: _add_gauge(
            filter_, sensor, around, "depth", _nominal_metre_pa(sensor, around) / around.metre_pa
        ),
        lambda sensor, around: dict(GAUGE_TERMS),
        lambda sensor, samples, around: (
            samples.valid, around.depth_m(samples.readings * _nominal_metre_pa(sensor, around))
        ),
    ),
    "pressure": Aid(
        lambda filter_, sensor, around: _add_gauge(filter_, sensor, around, "pressure", 1.0 / around.metre_pa),
        lambda sensor, around: dict(GAUGE_TERMS),
        lambda sensor, samples, around: (samples.valid, around.depth_m(samples.readings - ATMOSPHERE_PA)),
    ),
    # Its errors grow as the secant of the latitude. It has no iron, and points to true north.
    "gyrocompass": Aid(
        lambda filter_, sensor, around: _add_heading(
            filter_, sensor, 1.0 / math.cos(math.radians(sensor.spec.parameters["latitude_deg"][0])), 0.0
        ),
        lambda sensor, around: {"drift": 1},
        lambda sensor, samples, around: (samples.valid, north_rad(sensor) - samples.readings),
    ),
    # The declination is known from the chart; only the magnitude of the hard-iron error is known.
    "compass": Aid(
        _add_compass,
        lambda sensor, around: {"drift": 1, "hard_iron": 3},
        lambda sensor, samples, around: (samples.valid, north_rad(sensor) - samples.readings),
    ),
    # The fixes of a USBL arrive with a delay, and with the place where its station takes itself to be.
    "usbl": Aid(_add_fixes, _fix_terms, _fixes),
    # A satellite receiver, while it has a fix.
    "gps": Aid(
        _add_satellites,
        lambda sensor, around: {"orbits": 3},
        lambda sensor, samples, around: (
            samples.valid & np.isfinite(samples.readings[:, :6]).all(axis=1), samples.readings[:, :6]
        ),
    ),
    # The orientation measured by an IMU, for vehicles without a compass.
    "imu": Aid(
        lambda filter_, sensor, around: filter_.add_orientation(
            white_std(sensor, "orientation"), bias_model(sensor, "orientation")
        ),
        lambda sensor, around: {"orientation": 3},
        _orientations,
    ),
}  # fmt: skip
"""The aids by sensor kind."""
COMPASSES = ("gyrocompass", "compass")
"""The kinds that measure a heading, the better one first."""
GAUGES, LEVEL = ("depth", "pressure"), 3
"""The kinds whose biases include those of the water above, and the position of the surface's height among them."""


def chosen_aids(sensors: dict[str, InstrumentLike]) -> dict[str, InstrumentLike]:
    """Return the sensors that aid the filter, keyed by name. They are the first of each kind.

    Depth is preferred to the equivalent pressure, a gyrocompass to a compass, and the IMU's own orientation is used
    only without either.
    """
    first: dict[str, tuple[str, InstrumentLike]] = {}
    for name, sensor in sensors.items():
        if sensor.kind in AIDS:
            first.setdefault(sensor.kind, (name, sensor))
    if "depth" in first:
        first.pop("pressure", None)
    for better, worse in (("gyrocompass", "compass"), ("gyrocompass", "imu"), ("compass", "imu")):
        if better in first:
            first.pop(worse, None)
    return dict(first.values())
