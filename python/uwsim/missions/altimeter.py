"""The instrument by which a mission measures its height above the bed, whatever its name."""

from __future__ import annotations

from typing import Any

from uwsim.navigation.control.protocols import SensorLike

NAME = "altitude"


def altimeter(vehicle: Any) -> SensorLike | None:
    """Return the sensor named "altitude", else the first of the kind `altitude`, else None.

    Vehicles of which only the names are known, such as remote ones, have sensors without kinds.
    """
    sensors = vehicle.sensors
    if NAME in sensors:
        return sensors[NAME]  # type: ignore[no-any-return]
    return next((sensor for sensor in sensors.values() if getattr(sensor, "kind", None) == NAME), None)
