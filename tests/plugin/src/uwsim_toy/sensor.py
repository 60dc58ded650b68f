"""The sensor `light`: how bright it is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from uwsim.scenario.spec.sensor_kind import DerivedKind, Figure


def measure(values: Mapping[str, Any], figures: Mapping[str, float], time_s: float) -> dict[str, float]:
    """Return the daylight at the sensor, which decreases exponentially with depth."""
    depth_m = max(0.0, -values["position_m"][2])
    return {"irradiance": figures["surface_w_m2"] * math.exp(-figures["attenuation_1_m"] * depth_m)}


def write(value: float, header: Any, variance: Mapping[str, float]) -> dict[str, Any]:
    """Return the fields of a sensor_msgs/Illuminance, with 120 lx for 1 W/m^2 of daylight."""
    return {"header": header, "illuminance": 120.0 * value, "variance": 120.0**2 * variance["irradiance"]}


LIGHT = DerivedKind(
    name="light",
    meaning="downwelling daylight",
    source="position",
    fields={"irradiance": (1, "W/m^2")},
    measure=measure,
    parameters={
        "surface_w_m2": Figure(500.0, 0.0, 2000.0, "W/m^2", "irradiance just below the surface"),
        "attenuation_1_m": Figure(0.1, 0.0, 10.0, "1/m", "diffuse attenuation coefficient"),
    },
    type="sensor_msgs/msg/Illuminance",
    write=write,
)
