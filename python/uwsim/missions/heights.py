"""Heights at which missions fly: level, or a yo-yo, which goes down and up between two limits at a slope."""

from __future__ import annotations

import math
from dataclasses import dataclass

HIGHEST_Z_M = -1.5
"""No mission makes a vehicle climb above this height."""
STEEPEST_DEG = 18.0  # controllers pitch by at most 20 degrees to climb
LAG_M = 3.0  # the ramp waits for a vehicle that is farther off
EARLY_SHARE = 0.25  # of the height between the limits: a ramp turns no earlier before a limit
LESS = 0.25  # of what the vehicle stayed short of a limit, by which the ramp turns later next time
UNLEVEL_M, SWINGS, SWING_S = 1.0, 5, 60.0
OWN = 3.0  # a swing by itself is so much larger than the wanted height's change meanwhile
BAND = 6.0


@dataclass(frozen=True)
class YoYo:
    """Limits of a yo-yo: depths, or heights above the bed if `above_bed`.

    slope_deg: of the path, down and up. clear_m: the least height above the bed, and above all that the sonar sees
    ahead. The vehicle stays 1.5 m below the surface. Raises ValueError for limits in the wrong order or a slope beyond
    18 degrees.
    """

    upper_m: float
    lower_m: float
    above_bed: bool = False
    slope_deg: float = 12.0
    clear_m: float = 3.0

    def __post_init__(self) -> None:
        if not 0.0 < self.slope_deg <= STEEPEST_DEG:
            raise ValueError(f"yoyo: slope_deg = {self.slope_deg:g} deg: must be in (0, {STEEPEST_DEG:g}] deg")
        if not self.clear_m > 0.0:
            raise ValueError(f"yoyo: clear_m = {self.clear_m:g} m: must be positive")
        least, most = (self.lower_m, self.upper_m) if self.above_bed else (self.upper_m, self.lower_m)
        if not 0.0 <= least < most < math.inf:
            what = "heights above the bed, lower_m below upper_m" if self.above_bed else "depths, upper_m above lower_m"
            raise ValueError(f"yoyo: upper_m = {self.upper_m:g} m, lower_m = {self.lower_m:g} m: must be {what}")

    @property
    def height_m(self) -> float:
        """The height between the limits."""
        return abs(self.upper_m - self.lower_m)

    def limits_z_m(self, top_m: float) -> tuple[float, float]:
        """Return the lower and the upper limit z over the bed, or what the sonar sees ahead, at height top_m."""
        low, high = (top_m + self.lower_m, top_m + self.upper_m) if self.above_bed else (-self.lower_m, -self.upper_m)
        high = min(high, HIGHEST_Z_M)
        return min(max(low, top_m + self.clear_m), high), high


@dataclass
class HeightState:
    """The progress of a yo-yo, and what level flight was like before it.

    yoyo: None in level flight. z_m: the ramp's height; None before it begins. top_m: the last height of the bed, or of
    what the sonar saw ahead; None before. early_m: how far before the lower and the upper limit the ramp turns, so that
    the vehicle just reaches them. past_m: how far it has gone past the last one, negative before it. side, swings,
    since_s: the side of the wanted height on which it was last, how often it has changed sides by itself, and when.
    swung_m: its height and the wanted one then. widest_m: its largest distance from the wanted height since.
    """

    yoyo: YoYo | None = None
    z_m: float | None = None
    top_m: float | None = None
    descending: bool = True
    early_m: tuple[float, float] = (0.0, 0.0)
    past_m: float | None = None
    side: int = 0
    swung_m: tuple[float, float] = (0.0, 0.0)
    swings: int = 0
    since_s: float = 0.0
    widest_m: float = 0.0

    def next_z_m(self, z_m: float, top_m: float, ground_m: float) -> float:
        """Return the height to steer for. ground_m: the distance flown over ground since the last call.

        z_m: the vehicle's height. top_m: that of the bed, or of what the sonar sees ahead; -inf if it sees neither: the
        last one then counts, and without one a yo-yo above the bed stays level.
        """
        assert self.yoyo is not None
        if math.isfinite(top_m):
            self.top_m = top_m
        elif self.top_m is not None:
            top_m = self.top_m
        low, high = self.yoyo.limits_z_m(top_m)
        if not math.isfinite(low):
            return min(z_m, HIGHEST_Z_M)
        ramp = z_m if self.z_m is None else self.z_m
        past_m = z_m - high if self.descending else low - z_m
        self.past_m = past_m if self.past_m is None else max(self.past_m, past_m)
        if abs(ramp - z_m) < LAG_M:
            ramp += math.copysign(math.tan(math.radians(self.yoyo.slope_deg)) * ground_m, -1 if self.descending else 1)
        at_low, at_high = self.early_m
        if ramp <= low + at_low if self.descending else ramp >= high - at_high:
            self._turn()
        self.z_m = min(max(ramp, min(top_m + self.yoyo.clear_m, high)), high)
        return self.z_m

    def _turn(self) -> None:
        """Turn the ramp, and learn from how the vehicle passed the limit before."""
        assert self.yoyo is not None
        before = 1 if self.descending else 0
        if self.past_m is not None and self.z_m is not None:
            learnt = list(self.early_m)
            change_m = self.past_m if self.past_m > 0.0 else LESS * self.past_m
            learnt[before] = min(max(learnt[before] + change_m, 0.0), EARLY_SHARE * self.yoyo.height_m)
            self.early_m = learnt[0], learnt[1]
        self.descending, self.past_m = not self.descending, None

    def swings_about(self, z_m: float, wanted_m: float, time_s: float) -> bool:
        """Note the height in level flight; return True once the vehicle keeps swinging about the wanted one."""
        off_m = z_m - wanted_m
        side = 0 if abs(off_m) < UNLEVEL_M else int(math.copysign(1, off_m))
        if time_s > self.since_s + SWING_S:
            self.swings = 0
        if side and side != self.side:
            then_m, wanted_then_m = self.swung_m
            by_itself = abs(z_m - then_m) > OWN * abs(wanted_m - wanted_then_m)  # rather than with the bed
            self.swings = self.swings + 1 if self.side and by_itself else 0
            self.side, self.since_s, self.swung_m = side, time_s, (z_m, wanted_m)
        self.widest_m = max(self.widest_m, abs(off_m)) if self.swings else 0.0
        return self.swings >= SWINGS

    def begin_yoyo(self, altitude_m: float) -> YoYo:
        """Begin a yo-yo above a height above the bed, so wide that the swings in level flight are small beside it."""
        self.yoyo = YoYo(altitude_m + BAND * self.widest_m, altitude_m, above_bed=True, clear_m=altitude_m)
        return self.yoyo
