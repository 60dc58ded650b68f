"""The plan of a lawn-mower survey: area, altitude, speed and lane spacing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uwsim.base.arguments import require_positive
from uwsim.missions.heights import YoYo
from uwsim.missions.lanes import Lane, Point, lawn_mower_lanes
from uwsim.missions.moves import require_speed

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

    def lanes_near(self, near_m: Point) -> list[Lane]:
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
