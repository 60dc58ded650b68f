"""The needs of the adaptive lawn-mower: a sonar, an altimeter, and forces that move, lift and turn the vehicle."""

from __future__ import annotations

from typing import Any

from uwsim.base.axes import AXES
from uwsim.missions.altimeter import altimeter

DRIVES = {
    ("surge",): "by which it flies along a lane",
    ("heave", "pitch"): "by which it keeps its height",
    ("yaw",): "by which it turns",
}
"""The axes of which at least one must be driven, with the use that a lawn-mower makes of them."""


def missing_for_lanes(vehicle: Any) -> list[str]:
    """Return a clause for each thing that a vehicle lacks and the lawn-mower needs; none if it can fly lanes."""
    found = [] if _has_sonar(vehicle) else ["it carries no sonar, by which it sees the water ahead"]
    if altimeter(vehicle) is None:
        found.append("it has no sensor of kind 'altitude', by which it keeps its height above the bed")
    driven = getattr(vehicle, "controllable", set(AXES))  # remote vehicles do not report it
    return found + [
        f"nothing drives its {' or '.join(axes)}, {use}" for axes, use in DRIVES.items() if not driven & set(axes)
    ]


def _has_sonar(vehicle: Any) -> bool:
    try:
        return vehicle.sonar is not None
    except ValueError:
        return False
