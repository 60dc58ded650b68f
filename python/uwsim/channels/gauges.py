"""The panel's values, which come from the vehicle's instruments and its estimate, never from the true world."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.source import Source
from uwsim.navigation.estimation import Navigator
from uwsim.simulator.simulator import Simulator

NAN = math.nan
SCALARS = {
    "depth": "depth", "pressure": "pressure", "temperature": "temperature", "distance_to_seabed": "altitude"
}  # fmt: skip
"""The kind of sensor that measures each field of /telemetry."""
PORT = "proximity_port"


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

    def take(field: str, name: str | None, missing: Any = NAN, part: str = "") -> None:
        if name is None:
            found.values[field], found.ages_s[field] = missing, math.inf
            return
        sample = sensors[name].sample()
        value = getattr(sample.value, part) if part else sample.value
        is_known = sample.valid or bool(np.all(np.isinf(value)))  # infinite: no echo
        found.values[field] = value if is_known else missing
        found.ages_s[field] = 1e-9 * (sim.time_ns - sample.stamp_ns) if is_known else math.inf

    def first(kind: str) -> str | None:
        return next((name for name, sensor in sensors.items() if sensor.kind == kind), None)

    for field, kind in SCALARS.items():
        take(field, first(kind))
    take("distance_to_port", PORT if PORT in sensors else None)
    for field in ("linear_acceleration", "angular_acceleration"):
        take(field, first("acceleration"), np.full(3, NAN), f"{field}_{'m_s2' if field[0] == 'l' else 'rad_s2'}")
    _estimated(found, sim, estimate)
    return found


def _estimated(found: Gauges, sim: Simulator, estimate: Navigator | None) -> None:
    """Add the values derived from the estimate."""
    values: dict[str, float] = dict.fromkeys(("speed", "angular_speed", "distance_to_station", "link_delay"), NAN)
    age_s = math.inf
    if estimate is not None:
        age_s = sim.time_s - estimate.time_s
        away_m = estimate.pose.position_world_m - np.asarray(sim.scenario.station.position_m)
        values["speed"] = _size(estimate.velocity.linear_body_m_s)
        values["angular_speed"] = _size(estimate.velocity.angular_body_rad_s)
        values["distance_to_station"] = distance_m = _size(away_m)
        middle_m = min(0.5 * float(estimate.pose.position_world_m[2]), 0.0)
        values["link_delay"] = distance_m / sim.world.water.sound_speed_m_s(middle_m)
    found.values |= values
    found.ages_s |= dict.fromkeys(("position", *values), age_s)


def _size(vector: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(vector))
