"""fly_lanes: flies an area's lanes without leaving the area, avoiding everything that the sonar shows to be too high.

A lane is a row of points. The part covered by a shoal is trimmed. The part behind a shoal is flown immediately if the
detour is short, and otherwise after the other lanes, using everything charted by then. Points that the sonar has seen
from elsewhere are skipped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.missions.lanes import LANE_FLOWN, LANES_FLOWN, Lane
from uwsim.missions.planners.area_chart import AreaChart
from uwsim.missions.planners.area_pilot import AreaPilot
from uwsim.missions.planners.wayfinder import GRACE_S, Wayfinder
from uwsim.missions.steps import Steps

POINT_M = 1.0  # distance between the points of a lane
PASSED_M = 2.0  # a point passed within this distance counts as flown
AIM_M, LOOK_M = 3.0, 6.0  # distance ahead on the lane to steer for, over which the lane must be open
ROUND, ROUND_M = 2.5, 8.0  # a detour is short if it is at most ROUND times the straight distance, or that plus ROUND_M


@dataclass(frozen=True)
class FlownLanes:
    """The outcome of `fly_lanes`.

    left_out: indices of the lanes that were not flown at all. flown_m: total length flown. trimmed_m: too close to
    shoals. unreached_m: that no path in the area led to. seen_m: not flown but seen from elsewhere.
    """

    left_out: tuple[int, ...]
    flown_m: float
    trimmed_m: float
    unreached_m: float
    seen_m: float


def fly_lanes(lookout: Wayfinder, lanes: Sequence[Lane], chart: AreaChart) -> Steps[FlownLanes]:
    """Fly lanes in order, then the parts left over.

    Logs `trimmed` for parts known to be too high before the flight, `lane` at the beginning of each lane, `left_over`
    when the vehicle returns to a lane, `left_out`, and the lengths flown and planned: `lane_flown` of each lane,
    `lanes_flown` of all. The lookout must pass its echoes to the chart. Raises StoppedError if the vehicle cannot
    continue.
    """
    return (yield from _LaneFlight(lookout, lanes, chart).steps())


class _LaneFlight:
    """The progress of `fly_lanes`.

    _left: for each lane, the points still to be flown. _next: for each lane, the index after the last flown point.
    _flown, _trimmed, _unreached, _seen: for each lane, the number of points flown, and not flown for each reason.
    """

    def __init__(self, lookout: Wayfinder, lanes: Sequence[Lane], chart: AreaChart) -> None:
        self._lookout, self._vehicle, self._chart = lookout, lookout.vehicle, chart
        self._pilot = AreaPilot(lookout, chart)
        self._points = [_points(lane) for lane in lanes]
        self._left = [np.ones(len(points), bool) for points in self._points]
        self._next, self._flown, self._trimmed, self._unreached, self._seen = ([0] * len(lanes) for _ in range(5))

    def steps(self) -> Steps[FlownLanes]:
        for k in range(len(self._points)):
            if trimmed := self._trim(k):
                self._vehicle.log("trimmed", number=k, length_m=trimmed * POINT_M, reason="the map shows it too high")
        for k in range(len(self._points)):
            self._vehicle.log("lane", number=k, of=len(self._points))
            yield from self._lane(k)
        while (nearest := self._nearest_left()) is not None:
            x, y = self._first(nearest, self._pilot.here(), in_order=False)[0].tolist()
            self._vehicle.log("left_over", number=nearest, position_m=[x, y])
            yield from self._piece(nearest, False)
        left_out = tuple(k for k, flown in enumerate(self._flown) if not flown)
        for k in left_out:
            self._vehicle.log("left_out", number=k)
        self._log_lengths()
        counts = (self._flown, self._trimmed, self._unreached, self._seen)
        return FlownLanes(left_out, *(POINT_M * sum(each) for each in counts))

    def _log_lengths(self) -> None:
        """Log the lengths flown and planned, lane by lane and in total."""
        for k, points in enumerate(self._points):
            counts = {
                "too close to shoals": self._trimmed[k],
                "without a path to them": self._unreached[k],
                "seen from elsewhere": self._seen[k],
            }
            because = ", ".join(f"{count * POINT_M:g} m {reason}" for reason, count in counts.items() if count)
            self._vehicle.log(
                LANE_FLOWN, number=k, flown_m=self._flown[k] * POINT_M, planned_m=len(points) * POINT_M,
                **({"because": because} if because else {}),
            )  # fmt: skip
        planned_m = POINT_M * sum(map(len, self._points))
        self._vehicle.log(LANES_FLOWN, lanes=len(self._points), flown_m=POINT_M * sum(self._flown), planned_m=planned_m)

    def _trim(self, k: int) -> int:
        """Drop the points known to be too high; return how many were dropped."""
        closed = self._left[k] & ~self._chart.open_at(self._points[k])
        self._left[k] &= ~closed
        self._trimmed[k] += int(closed.sum())
        return int(closed.sum())

    def _lane(self, k: int) -> Steps[None]:
        """Fly a lane for the first time, in order or from its nearest point, while detours around shoals are short."""
        in_order = True
        while True:
            self._trim(k)
            if not self._left[k][self._next[k] if in_order else 0 :].any():
                return
            here = self._pilot.here()
            point, length_m = self._first(k, here, in_order=in_order)
            straight_m = float(np.linalg.norm(point - here))
            short_m = max(ROUND * straight_m, straight_m + ROUND_M)
            short = length_m <= short_m and (yield from self._piece(k, in_order, short_m))
            if not short and not in_order:
                return
            in_order = short

    def _nearest_left(self) -> int | None:
        """Return the lane with the nearest remaining point, after dropping points already seen or unreachable."""
        ways, nearest_m, nearest = self._chart.ways_from(self._pilot.here()), math.inf, None
        for k, points in enumerate(self._points):
            self._trim(k)
            seen = self._left[k] & self._chart.seen_at(points)
            self._left[k] &= ~seen
            self._seen[k] += int(seen.sum())
            if not self._left[k].any():
                continue
            lengths_m = np.where(self._left[k], ways.lengths_m(points), np.inf)
            unreached = self._left[k] & ~np.isfinite(lengths_m)
            self._left[k] &= ~unreached
            self._unreached[k] += int(unreached.sum())
            if lengths_m.min() < nearest_m:
                nearest_m, nearest = float(lengths_m.min()), k
        return nearest

    def _first(self, k: int, here: Floats, *, in_order: bool) -> tuple[Floats, float]:
        """Return the point of a lane to start at (the next or the nearest one remaining) and the path length to it."""
        lengths_m = np.where(self._left[k], self._chart.ways_from(here).lengths_m(self._points[k]), np.inf)
        at = self._next[k] + int(np.argmax(self._left[k][self._next[k] :])) if in_order else int(np.argmin(lengths_m))
        return self._points[k][at], float(lengths_m[at])

    def _piece(self, k: int, in_order: bool, short_m: float = math.inf) -> Steps[bool]:
        """Travel to the remaining part of a lane, and fly along it until it ends or an obstacle is in the way.

        Returns False if the path to it turned out to be longer than short_m.
        """
        goal = self._first(k, self._pilot.here(), in_order=in_order)[0]
        at = int(np.argmin(np.linalg.norm(self._points[k] - goal, axis=1)))
        gone = yield from self._pilot.go_to(goal, short_m)
        if not gone:
            self._give_up(k, at, gone is not None)
            return gone is not None
        left = self._left[k]
        after, before = int(np.argmin(np.append(left[at:], False))), int(np.argmin(np.append(left[at::-1], False)))
        yield from self._along(k, at, 1 if in_order or after >= before else -1)
        self._give_up(k, at, True)
        return True

    def _give_up(self, k: int, at: int, for_good: bool) -> None:
        """Drop a point that still remains after an attempt to reach it."""
        if for_good and self._left[k][at]:
            self._left[k][at] = False
            self._unreached[k] += 1

    def _along(self, k: int, at: int, step: int) -> Steps[None]:
        """Fly along a lane from one of its points, up (step = 1) or down (-1), until it ends or is blocked ahead."""
        points, left = self._points[k], self._left[k]
        end = at + step * int(np.argmin(np.append(left[at::step], False)))  # one past the last point of the run
        direction = step * (points[-1] - points[0]) / max(float(np.linalg.norm(points[-1] - points[0])), 1e-9)
        end_s = self._vehicle.time_s + GRACE_S + 5.0 * abs(end - at) * POINT_M / self._lookout.speed_m_s
        while at != end:
            here = self._pilot.here()
            away = points[at] - here
            if float(away @ direction) < 0.5 * POINT_M and float(np.linalg.norm(away)) < PASSED_M:
                left[at], self._next[k], self._flown[k] = False, max(self._next[k], at + 1), self._flown[k] + 1
                at += step
                continue
            ahead_m = min(LOOK_M, abs(end - step - at) * POINT_M)
            if not self._chart.straight(here, points[at] + ahead_m * direction) or not (yield from self._pilot.clear()):
                self._trim(k)
                return
            if self._vehicle.time_s > end_s:
                left[at] = False
                self._unreached[k] += 1
                return
            yield from self._lookout.towards(points[at] + AIM_M * direction)


def _points(lane: Lane) -> Floats:
    count = max(1, round(lane.length_m / POINT_M))
    return np.asarray(lane.start_m + np.linspace(0.0, 1.0, count + 1)[:, None] * (lane.end_m - lane.start_m))
