"""Plans drawn on the chart, which are saved as mission files for `uwsim run` or flown here by the same mission."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwsim.base.arguments import is_within
from uwsim.channels.guest import Values
from uwsim.flight.flyable_lanes import STEP_M, flyable_lanes, required_survey, survey_plan
from uwsim.live import LiveSimulator
from uwsim.live.clock import MissionClock
from uwsim.missions import StoppedError
from uwsim.missions.heights import HIGHEST_Z_M
from uwsim.missions.moves import visit
from uwsim.missions.own_vehicle import Event, OwnVehicle
from uwsim.missions.run import run
from uwsim.scenario import start_pose
from uwsim.simulator.simulator import Simulator

POINTS_MAX = 200
FAR_M = 10_000.0
SPEEDS_M_S = (0.05, 3.0)
FILE = '''\
"""Waypoints drawn on the chart of the operator's station, in the world frame: x east, y north, z up [m].

uwsim run {name}.py --scenario {scenario}
"""

from uwsim.missions import visit

POINTS_WORLD_M = [
{points}]
SPEED_M_S = {speed:g}


def mission(vehicle):
    yield from visit(vehicle, POINTS_WORLD_M, SPEED_M_S)
'''


@dataclass(frozen=True)
class Plan:
    """Waypoints (x, y, z) in the world frame [m], and the speed."""

    points_world_m: list[tuple[float, float, float]]
    speed_m_s: float

    @classmethod
    def of(cls, request: Values, origin_m: Sequence[float]) -> Plan:
        """Return the plan in a request, whose points are in the odom frame at origin_m. Raises ValueError."""
        points, speed = request.get("points_m"), request.get("speed_m_s", 0.5)
        if not isinstance(points, list) or not 1 <= len(points) <= POINTS_MAX:
            raise ValueError(f"points_m: must be a list of 1 to {POINTS_MAX} points")
        for k, point in enumerate(points):
            if not isinstance(point, list) or len(point) != 3 or not all(is_within(x, -FAR_M, FAR_M) for x in point):
                raise ValueError(f"points_m[{k}]: must be three numbers in [-{FAR_M:g}, {FAR_M:g}] m")
        if not is_within(speed, *SPEEDS_M_S):
            raise ValueError(f"speed_m_s = {str(speed)[:40]}: must be in {list(SPEEDS_M_S)} m/s")
        x, y, z = (float(value) for value in origin_m)
        return cls([(p[0] - x, p[1] - y, min(p[2] - z, 0.0)) for p in points], float(speed))

    def in_odom(self, origin_m: Sequence[float]) -> list[list[float]]:
        """Return the points in the odom frame at origin_m."""
        x, y, z = (float(value) for value in origin_m)
        return [[round(each, 3) for each in (p[0] + x, p[1] + y, p[2] + z)] for p in self.points_world_m]

    def file(self, name: str, scenario: str) -> str:
        """Return the text of a mission's file."""
        points = "".join(f"    ({x:.3f}, {y:.3f}, {z:.3f}),\n" for x, y, z in self.points_world_m)
        return FILE.format(name=name, scenario=scenario, points=points, speed=self.speed_m_s)


class _Clock:
    """A mission clock that ends the mission on request."""

    def __init__(self, clock: MissionClock, flight: PlanFlight) -> None:
        self._clock, self._flight = clock, flight

    @property
    def time_s(self) -> float:
        return float(self._clock.time_s)

    def wait(self, duration_s: float) -> None:
        self._require_flying()
        self._clock.wait(duration_s)
        self._require_flying()

    def _require_flying(self) -> None:
        if self._flight.stopped_because:
            raise StoppedError(self._flight.stopped_because)


class PlanFlight:
    """Flies a plan on a separate thread, using the vehicle's own estimate, until it ends or `stop` is called.

    Simulated time does not pass while the mission decides, so that no delay of this thread changes what is flown.
    """

    def __init__(self, live: LiveSimulator, vehicle: str, plan: Plan) -> None:
        self.plan, self.reached, self.ended_because, self.stopped_because = plan, 0, "", ""
        self._live, self._hull = live, live.vehicles[vehicle]
        self._thread = threading.Thread(target=self._fly, name="uwsim-plan", daemon=True)
        self._thread.start()

    @property
    def is_on(self) -> bool:
        """True while the plan is being flown."""
        return not self.ended_because

    def stop(self, because: str) -> None:
        """End the flight at the next control period."""
        self.stopped_because = self.stopped_because or because

    def report(self) -> Values:
        """Return the flight's state as fields of a response."""
        return {"is_flying": self.is_on, "reached": self.reached, "ended_because": self.ended_because}

    def _note(self, event: Event) -> None:
        if event.name == "waypoint":
            self.reached = int(event.values["number"])

    def _fly(self) -> None:
        ended = "all waypoints are reached"
        try:
            with self._live.mission_clock() as clock:
                own = OwnVehicle(self._hull, clock, estimate=self._hull.start_navigation(), hear=self._note)
                run(mission_of(self.plan), own, _Clock(clock, self))
                self._hull.set_effort()
        except Exception as error:  # StoppedError, or the simulator was stopped, reset or failed
            ended = str(error) or type(error).__name__
            if not self.stopped_because:
                self._end_efforts()
        self.ended_because = ended

    def _end_efforts(self) -> None:
        try:
            self._hull.set_effort()
        except Exception as error:
            self.stopped_because = str(error)


def survey_lanes(sim: Simulator) -> Plan:
    """Return the ends of the lanes of a scenario's survey, each level at the survey's altitude above what lies below.

    Raises ScenarioError if it has none, or if its lanes cannot be flown.
    """
    survey = required_survey(sim.scenario)
    start_m, _ = start_pose(sim.scenario, sim.scenario.vehicles[0])
    lanes = flyable_lanes(sim, survey_plan(survey).lanes_near(np.array(start_m[:2]))).lanes
    points = []
    for lane in lanes[: POINTS_MAX // 2]:
        along_m = np.arange(0.0, lane.length_m + STEP_M, STEP_M)
        from_m = np.column_stack([lane.start_m + along_m[:, None] * lane.direction, np.full(len(along_m), HIGHEST_Z_M)])
        down = np.tile([0.0, 0.0, -1.0], (len(from_m), 1))
        clear_m = float(sim.scene.cast(from_m, down, FAR_M).ranges_m.min())
        z_m = min(HIGHEST_Z_M - clear_m + survey.altitude_m, HIGHEST_Z_M)
        points += [(float(x), float(y), z_m) for x, y in (lane.start_m, lane.end_m)]
    return Plan(points, survey.speed_m_s)


def mission_of(plan: Plan) -> Any:
    """Return the mission that flies a plan."""

    def mission(vehicle: OwnVehicle) -> Any:
        return (yield from visit(vehicle, plan.points_world_m, plan.speed_m_s))

    return mission
