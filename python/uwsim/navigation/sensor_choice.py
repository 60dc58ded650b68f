"""The instruments by which a vehicle finds its height above the bed and things to port, whatever their names."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from uwsim.base import quaternions

S = TypeVar("S")
ALTITUDE, PROXIMITY = "altitude", "proximity"
PORT_NAME = "proximity_port"
MOST_ASIDE_RAD = math.radians(45.0)


def altimeter(sensors: Mapping[str, S]) -> S | None:
    """Return the sensor named "altitude", else the first of the kind `altitude`, else None.

    Vehicles of which only the names are known, such as remote ones, have sensors without kinds.
    """
    if ALTITUDE in sensors:
        return sensors[ALTITUDE]
    return next((sensor for sensor in sensors.values() if getattr(sensor, "kind", None) == ALTITUDE), None)


def height_above_bed_m(vehicle: Any) -> float:
    """Return the altimeter's reading; infinite without an echo. Raises ValueError without an altimeter."""
    if (found := altimeter(vehicle.sensors)) is None:
        raise ValueError("the vehicle has no sensor of kind 'altitude': missions steer by it")
    return float(found.read())


def port_proximity(sensors: Mapping[str, S]) -> S | None:
    """Return the sensor named "proximity_port", else the first of the kind `proximity` that measures to port."""
    if PORT_NAME in sensors:
        return sensors[PORT_NAME]
    return next((sensor for sensor in sensors.values() if _measures_to_port(sensor)), None)


def _measures_to_port(sensor: Any) -> bool:
    if getattr(sensor, "kind", None) != PROXIMITY:
        return False
    to_port = quaternions.matrix(np.asarray(sensor.spec.orientation_xyzw))[1, 0]
    return bool(to_port > math.cos(MOST_ASIDE_RAD))
