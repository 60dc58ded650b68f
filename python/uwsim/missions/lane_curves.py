"""Changes of lane for a vehicle that cannot go sideways: it flies curves ahead, and holds a line by its course."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from uwsim.missions.dubins import dubins_points
from uwsim.missions.lanes import Lane, LaneEnd
from uwsim.missions.lookout import Lookout
from uwsim.missions.steps import Steps, StoppedError
from uwsim.navigation.control.autopilot import wrap_angle
from uwsim.navigation.control.protocols import Watch

STEP_M = 0.5
FIRST_RATE_RAD_S, FIRST_RADIUS_M = 0.35, 2.0  # rate of turn of the first curve; it is flown wider until it succeeds
WIDER = 1.5
RUN_IN = 2.0  # distances ahead that are flown along a lane's line before the lane begins
GRACE_S = 60.0
ENTERED_M, ENTERED_RAD = 1.5, math.radians(60.0)  # how far from its line, and turned from it, a lane is entered
MOST_DRIFT_RAD = math.radians(40.0)
UNDER_WAY_M_S, TURNING_RAD_S = 0.2, 0.2
MOST_SLIP = math.tan(math.radians(30.0))  # sideways in parts of ahead; a blunt hull without sway slips on in its turns

SLIP_AHEAD_S, LEAD, DRIFT_S = 12.0, 2.0, 20.0
"""For a hull that slips: how far ahead, in time, it aims along a lane, as its course follows its heading after seconds;
how much farther it turns than its course has to; and the time over which its drift is averaged."""

Ended = Literal["entered", "missed", "blocked", "slipped"]
LegName = Literal["undock", "approach", "transit", "tilt", "turn", "abreast", "mow"]


@dataclass(frozen=True)
class LegStart:
    """Time and pose at the beginning of a leg."""

    time_s: float
    position_world_m: tuple[float, float, float]
    yaw_rad: float


@dataclass(slots=True)
class MowerState:
    """A mission's progress.

    lane: index of the current lane. leg: the leg being flown for that lane. along_m: current distance along the lane.
    furthest_m: the largest along_m so far, reached at furthest_s. skipped: number of lanes skipped as unreachable.
    legs: number of legs begun for the current lane. radius_m: for a vehicle without sway, the radius of its curves; 0
    before the first. reached: how far along a curve it is, in points. entry_m: where on the current lane it began to
    fly along it; None before that. ended: the lanes before the current one. stops: for a vehicle without sway, whether
    it has slipped too far in a curve, and since then stops to turn. drift_rad: its mean drift since then, from its
    heading to its course.
    """

    leg: LegName
    lane: int = 0
    along_m: float = 0.0
    furthest_m: float = 0.0
    furthest_s: float = 0.0
    skipped: int = 0
    legs: int = 0
    radius_m: float = 0.0
    reached: int = 0
    entry_m: float | None = None
    ended: list[LaneEnd] = field(default_factory=list)
    stops: bool = False
    drift_rad: float = 0.0


class LaneCurves:
    """Flies the curves of a survey. ahead_m: the distance ahead, on its path, to the point that the vehicle aims at.

    hovers: whether the vehicle could stop and turn instead, so that a curve ends where it slips. least_m_s: the speed
    ahead below which its fins do not turn it; it keeps this even where its aim is abeam or behind.
    """

    def __init__(
        self, lookout: Lookout, clock: Watch, speed_m_s: float, *, hovers: bool, least_m_s: float = 0.0
    ) -> None:
        self._lookout, self._clock, self._speed_m_s, self._hovers = lookout, clock, speed_m_s, hovers
        self._least_m_s = least_m_s
        self.ahead_m = 1.5 + 1.5 * speed_m_s

    def onto(self, lane: Lane, entry_m: NDArray[np.float64], start: LegStart, state: MowerState) -> Steps[Ended]:
        """Fly the shortest curve onto a lane, which the vehicle joins before a point of it.

        If it misses the lane, the next curve will be wider. Raises StoppedError if it is stuck.
        """
        state.radius_m = state.radius_m or max(FIRST_RADIUS_M, self._speed_m_s / FIRST_RATE_RAD_S)
        along_m = lane.locate(entry_m)[0]
        path = curve_onto(lane, along_m, start.position_world_m, start.yaw_rad, state.radius_m, RUN_IN * self.ahead_m)
        path.reached = state.reached
        end_s = start.time_s + GRACE_S + 3.0 * path.length_m / self._speed_m_s
        while True:
            here = self._here()
            aim, state.reached = path.aim(here, self.ahead_m), path.reached
            if path.is_straight and lane.locate(np.array(here))[0] >= along_m:
                break
            if self._lookout.shoals.blocks(here, aim):
                return "blocked"
            if self._hovers and slips(self._lookout.vehicle):
                return "slipped"
            if path.off_m > self.ahead_m:
                state.radius_m *= WIDER
                return "missed"
            if self._clock.time_s > end_s:
                raise StoppedError(f"stuck {math.dist(here, entry_m):.0f} m before a lane")
            yield from self.make_for(aim)
        if has_entered(lane, here, float(self._lookout.vehicle.pose.yaw_rad)):
            return "entered"
        state.radius_m *= WIDER
        return "missed"

    def around(self, goal_m: tuple[float, float], start: LegStart) -> Steps[bool]:
        """Fly around shoals until none is in the way of a point; return False if there is no path."""
        while (aim := self._lookout.shoals.next_point(self._here(), goal_m)) != goal_m:
            if aim is None or self._clock.time_s > start.time_s + GRACE_S:
                return aim is not None
            yield from self.make_for(aim)
        return True

    def make_for(self, aim_m: tuple[float, float]) -> Steps[None]:
        """Fly ahead for one control period, on a course over ground towards a point."""
        x, y = self._here()
        course_rad, speed = math.atan2(aim_m[1] - y, aim_m[0] - x), self._speed_m_s
        velocity = (speed * math.cos(course_rad), speed * math.sin(course_rad))
        yaw_rad = float(self._lookout.vehicle.pose.yaw_rad)
        if self._least_m_s > 0.0 and speed * math.cos(course_rad - yaw_rad) < self._least_m_s:
            velocity = (self._least_m_s * math.cos(yaw_rad), self._least_m_s * math.sin(yaw_rad))
        yield from self._lookout.steer(heading_for(course_rad, self._lookout.vehicle), velocity)

    def hold(self, lane: Lane, state: MowerState) -> Steps[None]:
        """Fly along a lane for one control period with a hull that slips.

        Its course lags behind its heading by the time in which the slip dies down, so that turning against the drift of
        the moment, as `make_for` does, would swing it from side to side. It leads the course instead, as far as that is
        off, and turns against a current's drift, the mean of some seconds.
        """
        vehicle, (x, y) = self._lookout.vehicle, self._here()
        along_m = lane.locate(np.array((x, y)))[0]
        aim_x, aim_y = lane.point(along_m + SLIP_AHEAD_S * self._speed_m_s)
        course_rad, yaw_rad = math.atan2(aim_y - y, aim_x - x), float(vehicle.pose.yaw_rad)
        surge_m_s, sway_m_s, _ = vehicle.velocity.linear_body_m_s
        off_rad = 0.0
        if surge_m_s > UNDER_WAY_M_S:
            drift_rad = math.atan2(sway_m_s, surge_m_s)
            state.drift_rad += self._lookout.period_s / DRIFT_S * (drift_rad - state.drift_rad)
            off_rad = LEAD * wrap_angle(course_rad - yaw_rad - drift_rad)
        turn_rad = min(max(off_rad - state.drift_rad, -MOST_DRIFT_RAD), MOST_DRIFT_RAD)
        velocity = (self._speed_m_s * math.cos(course_rad), self._speed_m_s * math.sin(course_rad))
        yield from self._lookout.steer(course_rad + turn_rad, velocity)

    def _here(self) -> tuple[float, float]:
        x, y, _ = self._lookout.vehicle.pose.position_world_m.tolist()
        return x, y


class PathAhead:
    """A path of points (n, 2) that ends in a straight piece, and how far along it a vehicle has come.

    straight_from: the index of the first point of the straight piece. reached: that of the point nearest to the
    vehicle, which lies off_m away.
    """

    def __init__(self, points_m: NDArray[np.float64], straight_from: int) -> None:
        self._points, self._straight_from, self.reached, self.off_m = points_m, straight_from, 0, 0.0

    @property
    def length_m(self) -> float:
        """The length of the path, about."""
        return STEP_M * len(self._points)

    @property
    def is_straight(self) -> bool:
        """True once the vehicle has reached the straight piece."""
        return self.reached >= self._straight_from

    def aim(self, position_m: Sequence[float], ahead_m: float) -> tuple[float, float]:
        """Return the point ahead_m further than the one nearest to the vehicle, which never goes back."""
        ahead = math.ceil(ahead_m / STEP_M)
        window = self._points[self.reached : self.reached + 2 * ahead]
        distances_m = np.linalg.norm(window - np.asarray(position_m)[:2], axis=1)
        nearest = int(np.argmin(distances_m))
        self.reached, self.off_m = self.reached + nearest, float(distances_m[nearest])
        x, y = self._points[min(self.reached + ahead, len(self._points) - 1)].tolist()
        return x, y


def curve_onto(
    lane: Lane, along_m: float, start_m: Sequence[float], yaw_rad: float, radius_m: float, run_in_m: float
) -> PathAhead:
    """Return the shortest path from a pose onto a lane's line, which it joins run_in_m before along_m of the lane."""
    join_m = lane.start_m + (along_m - run_in_m) * lane.direction
    turn = dubins_points((start_m[0], start_m[1], yaw_rad), (*join_m.tolist(), lane.heading_rad), radius_m, STEP_M)
    on = np.arange(STEP_M, 2.0 * run_in_m, STEP_M)
    return PathAhead(np.concatenate([turn, join_m + on[:, None] * lane.direction]), len(turn))


def has_entered(lane: Lane, position_m: Sequence[float], yaw_rad: float) -> bool:
    """Return whether a vehicle is on a lane's line, and turned along it, or across it against a current."""
    across_m = lane.locate(np.asarray(position_m))[1]
    return abs(across_m) <= ENTERED_M and abs(wrap_angle(yaw_rad - lane.heading_rad)) <= ENTERED_RAD


def is_under_way(vehicle: Any) -> bool:
    """Return whether a vehicle moves horizontally, ahead or aside."""
    surge_m_s, sway_m_s, _ = vehicle.velocity.linear_body_m_s
    return math.hypot(surge_m_s, sway_m_s) > UNDER_WAY_M_S


def slips(vehicle: Any) -> bool:
    """Return whether a vehicle goes sideways by more than its course can be held against."""
    surge_m_s, sway_m_s, _ = vehicle.velocity.linear_body_m_s
    return is_under_way(vehicle) and abs(sway_m_s) > MOST_SLIP * abs(surge_m_s)


def heading_for(course_rad: float, vehicle: Any) -> float:
    """Return the heading with which a vehicle makes a course over ground: against its drift, as measured now."""
    surge_m_s, sway_m_s, _ = vehicle.velocity.linear_body_m_s
    if surge_m_s < UNDER_WAY_M_S:
        return course_rad
    turning = min(abs(float(vehicle.velocity.angular_body_rad_s[2])) / TURNING_RAD_S, 1.0)  # in turns, it slips as well
    drift_rad = (1.0 - turning) * math.atan2(sway_m_s, surge_m_s)
    return course_rad - min(max(drift_rad, -MOST_DRIFT_RAD), MOST_DRIFT_RAD)
