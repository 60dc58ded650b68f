"""The needs of the adaptive lawn-mower: a sonar, an altimeter, and forces that move, lift and turn the vehicle."""

from __future__ import annotations

import math
from typing import Any

from uwsim.base.axes import AXES
from uwsim.navigation.sensor_choice import altimeter

SONAR, ALTIMETER = "sonar", "altimeter"
DRIVES = {
    ("surge",): "by which it flies along a lane",
    ("heave", "pitch"): "by which it keeps its height",
    ("yaw",): "by which it turns",
}
"""The axes of which at least one must be driven, with the use that a lawn-mower makes of them."""


def missing_for_lanes(vehicle: Any, altitude_m: float = 0.0) -> dict[str, str]:
    """Return a clause for each thing that a vehicle lacks and the lawn-mower needs; none if it can fly lanes.

    altitude_m: the height above the bed that it is to keep. The keys are SONAR, ALTIMETER and the first of the axes.
    """
    found = {} if _has_sonar(vehicle) else {SONAR: "it carries no sonar, by which it sees the water ahead"}
    if lack := _altimeter_lacks(altimeter(vehicle.sensors), altitude_m):
        found[ALTIMETER] = lack
    driven = getattr(vehicle, "controllable", set(AXES))  # remote vehicles do not report it
    for axes, use in DRIVES.items():
        if not driven & set(axes):
            found[axes[0]] = f"nothing drives its {' or '.join(axes)}, {use}"
    return found


def _has_sonar(vehicle: Any) -> bool:
    try:
        return vehicle.sonar is not None
    except ValueError:
        return False


def _altimeter_lacks(sensor: Any, altitude_m: float) -> str | None:
    use = "by which it keeps its height above the bed"
    if sensor is None:
        return f"it has no sensor of kind 'altitude', {use}"
    if not getattr(sensor, "on", True):
        return f"its altimeter is off, {use}"
    spec = getattr(sensor, "spec", None)  # remote vehicles do not report it
    range_m = math.inf if spec is None else float(spec.parameters.get("range_max_m", [math.inf])[0])
    if range_m <= altitude_m:
        return f"its altimeter, {use}, reaches {range_m:g} m, not {altitude_m:g} m"
    return None
