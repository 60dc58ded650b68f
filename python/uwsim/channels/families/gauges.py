"""The panel's values, which come from the vehicle's instruments and its estimate, never from the true world.

A vehicle with a sensor of kind position, such as that of the published simulator, shows what its position and velocity
sensors measure; any other shows its estimate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.ros import build
from uwsim.channels.ros.messages import to_plain
from uwsim.channels.ros.own_types import SENSOR_GAUGES
from uwsim.channels.source import Source
from uwsim.instruments.gauges import GAUGES
from uwsim.instruments.sensors import Sample, Sensor
from uwsim.navigation.estimation import Navigator
from uwsim.navigation.sensor_choice import port_proximity
from uwsim.scenario.spec.sensor_kind import DerivedKind, sensor_kind
from uwsim.simulator.simulator import Simulator

NAN = math.nan
KINDS = ("depth", "pressure", "temperature", "altitude", "proximity", "acceleration")
"""The kinds of sensors that measure gauges, in the order of /telemetry's list `gauges`."""
MEASURED = [gauge for kind in KINDS for gauge in GAUGES if gauge.sensor == kind]
UNKNOWN = np.full(3, NAN)
MOST = 6
"""The most numbers of a sensor that are gauges; one with more, such as a profile, is no row of numbers for a pilot."""
SPEEDS = {"linear": "speed", "angular": "angular_speed"}
POSITION, LINEAR, ANGULAR, VARIANCES = slice(1, 4), slice(8, 11), slice(11, 14), slice(23, 56, 16)
"""Parts of `Navigator.numbers`: the position, the velocities, and the position's variances."""


@dataclass
class Gauges:
    """The measured fields of /telemetry, and the age [s] of each.

    A field without a sensor has NaN and an infinite age.
    """

    values: dict[str, Any]
    ages_s: dict[str, float]


def gauges(sim: Simulator, source: Source, estimate: Navigator | None) -> Gauges:
    """Read the gauges. If a sensor is stuck, its gauge shows the last value; if it is off, NaN."""
    sensors = source.of(sim).sensors
    found = Gauges({}, {})

    def fill(field: str, name: str | None, missing: Any = NAN, part: str = "") -> None:
        if name is None:
            found.values[field], found.ages_s[field] = missing, math.inf
            return
        sample = sensors[name].sample()
        value = getattr(sample.value, part) if part else sample.value
        found.ages_s[field] = _age_s(sim, sample, value)
        found.values[field] = missing if math.isinf(found.ages_s[field]) else value

    first: dict[str, str | None] = {}
    for each, sensor in sensors.items():
        first.setdefault(sensor.kind, each)
    to_port = port_proximity(sensors)
    first["proximity"] = None if to_port is None else to_port.name
    for gauge in MEASURED:
        fill(gauge.name, first.get(gauge.sensor), *(() if gauge.width == 1 else (UNKNOWN, gauge.attribute)))
    if (name := first.get("position")) is not None:
        fill("position", name, UNKNOWN, "position_m")
        found.values["position_std"] = np.full(3, getattr(sensors[name].spec.noise.get("position"), "std", 0.0))
        for field in ("linear", "angular"):
            unit = "m_s" if field == "linear" else "rad_s"
            fill(SPEEDS[field], first.get("velocity"), UNKNOWN, f"{field}_velocity_{unit}")
    else:
        _estimate(found, sim, estimate)
    _derive(found, sim)
    return found


def _age_s(sim: Simulator, sample: Sample[Any], value: Any) -> float:
    """Return a sample's age, infinite without a valid measurement."""
    is_known = sample.valid or bool(np.all(np.isinf(value)))  # infinite: no echo
    return 1e-9 * (sim.time_ns - sample.stamp_ns) if is_known else math.inf


def gauge_sensors(sensors: Mapping[str, Sensor[Any]]) -> list[Sensor[Any]]:
    """Return the sensors of kinds in Python, each number of which is a gauge, unless there are too many."""
    found = [sensor for sensor in sensors.values() if isinstance(sensor_kind(sensor.kind), DerivedKind)]
    return [sensor for sensor in found if len(sensor.numbers) <= MOST]


def read_sensors(sim: Simulator, source: Source) -> Any:
    """Return the message with the gauges of sensors of kinds in Python."""
    numbers: dict[str, str] = {}
    values: list[float] = []
    ages_s: list[float] = []
    for sensor in gauge_sensors(source.of(sim).sensors):
        sample = sensor.sample()
        found = sensor.flat(sample.value)
        age_s = _age_s(sim, sample, found)
        numbers |= sensor.numbers
        values += [NAN] * len(found) if math.isinf(age_s) else found
        ages_s += [age_s] * len(found)
    return build.message(
        SENSOR_GAUGES,
        header=build.header(sim.time_ns, source.frame("base_link")),
        names=list(numbers),
        units=list(numbers.values()),
        values=np.array(values, np.float32),
        ages=np.array(ages_s, np.float32),
    )


def values_by_name(message: Any) -> dict[str, Any]:
    """Return the plain values of a panel's message, or of one with the gauges of sensors."""
    found: dict[str, Any] = to_plain(message)
    return dict(zip(found["names"], map(float, found["values"]), strict=True)) if "names" in found else found


def _estimate(found: Gauges, sim: Simulator, estimate: Navigator | None) -> None:
    """Add position and velocities by the estimate."""
    age_s, shown = math.inf, (UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN)
    if estimate is not None:
        numbers = estimate.numbers
        age_s = sim.time_s - float(numbers[0])
        shown = numbers[POSITION], np.sqrt(numbers[VARIANCES]), numbers[LINEAR], numbers[ANGULAR]
    found.values |= dict(zip(("position", "position_std", *SPEEDS.values()), shown, strict=True))
    found.ages_s |= dict.fromkeys(("position", "speed", "angular_speed"), age_s)


def _derive(found: Gauges, sim: Simulator) -> None:
    """Replace velocities by speeds, and add the distance to the station and the time that sound takes to it."""
    for field in SPEEDS.values():
        found.values[field] = _size(found.values[field])
    position_m = found.values["position"]
    found.values["distance_to_station"] = distance_m = _size(position_m - sim.station_world_m)
    is_known = math.isfinite(distance_m)
    middle_m = min(0.5 * float(position_m[2]), 0.0)
    found.values["link_delay"] = distance_m / sim.world.water.sound_speed_m_s(middle_m) if is_known else NAN
    found.ages_s |= dict.fromkeys(("distance_to_station", "link_delay"), found.ages_s["position"])


def _size(vector: NDArray[np.float64]) -> float:
    return math.sqrt(vector.dot(vector))  # as numpy.linalg.norm, which takes three times as long
