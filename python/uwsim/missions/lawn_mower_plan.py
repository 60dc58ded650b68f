"""The plan of a lawn-mower survey: area, altitude, speed and lane spacing; and what its vehicle needs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwsim.base.arguments import require_positive
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.missions.heights import YoYo
from uwsim.missions.lanes import Lane, lawn_mower_lanes
from uwsim.missions.moves import require_speed
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


SIDES = {"north": (0.0, 1.0), "south": (0.0, -1.0), "east": (1.0, 0.0), "west": (-1.0, 0.0)}
TRANSIT_VIEW_S = 20.0  # on transits, the fan hits a flat bed this many seconds ahead, early enough to see a rise


class SlowPlanWarning(UserWarning):
    """Issued for a plan that is slower than the vehicle can be steered."""


@dataclass(frozen=True)
class LawnMowerPlan:
    """How to survey an area in parallel lanes.

    area_m: the polygon's corners (k, 2). altitude_m: height above the bed. tilt_deg: the sonar's tilt, nose down.
    lanes: the lanes in flight order; by default, lanes that cover the whole area. yoyo: fly one instead of altitude_m
    above the bed. heading_deg, cross_lines: of the lanes by default, see lawn_mower_lanes. entry: the side or corner of
    the area where they begin, by default the one nearest to the vehicle. Raises ValueError for a length or a speed that
    is not positive, or a speed that no vehicle has.
    """

    area_m: Sequence[Sequence[float]]
    altitude_m: float = 8.0
    line_spacing_m: float = 5.0
    speed_m_s: float = 1.0
    tilt_deg: float = 30.0
    lanes: Sequence[Lane] | None = None
    yoyo: YoYo | None = None
    heading_deg: float | None = None
    cross_lines: int = 0
    entry: str | None = None

    def __post_init__(self) -> None:
        require_positive(
            "LawnMowerPlan", altitude_m=self.altitude_m, line_spacing_m=self.line_spacing_m, speed_m_s=self.speed_m_s
        )
        require_speed("LawnMowerPlan", self.speed_m_s)

    def lanes_near(self, near_m: Floats) -> list[Lane]:
        """Return the lanes that cover the whole area, begun near a point (2,) if there is no entry."""
        if self.entry is not None:
            area = np.asarray(self.area_m, np.float64)
            towards = np.sum([SIDES[side] for side in self.entry.split("-")], axis=0)
            near_m = area.mean(axis=0) + 2.0 * np.linalg.norm(np.ptp(area, axis=0)) * towards
        return lawn_mower_lanes(
            self.area_m, self.line_spacing_m, self.reach_m, near_m, heading_deg=self.heading_deg,
            cross_lines=self.cross_lines,
        )  # fmt: skip

    @property
    def reach_m(self) -> float:
        """Distance ahead at which the tilted fan hits a flat bed; lanes begin and end this far outside the polygon."""
        return float(np.clip(self.altitude_m / np.tan(np.radians(max(self.tilt_deg, 10.0))), 0.0, 20.0))

    @property
    def transit_view_m(self) -> float:
        """Distance ahead at which the fan hits a flat bed during a long transit to a lane."""
        return TRANSIT_VIEW_S * self.speed_m_s
