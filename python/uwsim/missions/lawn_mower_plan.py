"""The plan of a lawn-mower: the area to cover, the height, the speed and the density of lanes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uwsim.missions.lanes import Lane

TRANSIT_VIEW_S = 20.0  # time ahead at which the fan hits a flat bed in transits, so that a rise is seen in time


@dataclass(frozen=True)
class LawnMowerPlan:
    """How to mow an area. area_m: the polygon's corners (k, 2). altitude_m: above the bed. tilt_deg: nose down.

    lanes: flown in this order instead of lanes that cover the whole area.
    """

    area_m: Sequence[Sequence[float]]
    altitude_m: float = 8.0
    line_spacing_m: float = 5.0
    speed_m_s: float = 1.0
    tilt_deg: float = 30.0
    lanes: Sequence[Lane] | None = None

    @property
    def reach_m(self) -> float:
        """Distance ahead at which the tilted fan hits a flat bed; lanes begin and end this far outside the polygon."""
        return float(np.clip(self.altitude_m / np.tan(np.radians(max(self.tilt_deg, 10.0))), 0.0, 20.0))

    @property
    def transit_view_m(self) -> float:
        """Distance ahead at which the fan hits a flat bed on a long way to a lane."""
        return TRANSIT_VIEW_S * self.speed_m_s
