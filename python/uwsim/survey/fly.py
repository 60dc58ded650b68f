"""Fly a survey: a mission steers the vehicle, every ping goes through the chain into a map."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.control.protocols import Clock, SurveyVehicle
from uwsim.mapping import OccupancyMap
from uwsim.missions import COVERED, AdaptiveLawnMower, LawnMowerPlan, Mission
from uwsim.scenario import Scenario, ScenarioError, Survey, vehicle_hull
from uwsim.simulator import Simulator
from uwsim.survey.chain import ScanChain, SelfBox
from uwsim.survey.record import INTERRUPTED, PingSample, SurveyRecord
from uwsim.survey.stages import StageTimer
from uwsim.survey.true_surface import inside_polygon

SELF_MARGIN_M = 0.05


@dataclass
class SurveyLog:
    """What is noted of each ping as the survey goes on."""

    area_world_m: NDArray[np.float64]
    positions_world_m: list[NDArray[np.float64]] = field(default_factory=list)
    echo_count: int = 0
    richest: PingSample | None = None
    richest_score: float = -1.0

    def note(self, ping: _core.Ping, points_world_m: NDArray[np.float32]) -> None:
        """Keep the ping's place, count its echoes, and keep the most telling ping for the report's picture."""
        position = ping.world_from_sonar[:3, 3]
        self.positions_world_m.append(position)
        self.echo_count += len(points_world_m)
        if not inside_polygon(position[None, :2], self.area_world_m)[0]:
            return
        # The picture wants a full fan that also meets something other than the bed.
        things = len(np.unique(ping.labels[ping.valid]))
        score = 100.0 * things + float(ping.valid.mean())
        if score > self.richest_score:
            self.richest_score = score
            self.richest = PingSample(ping.ranges_m, ping.angles_rad, ping.world_from_sonar, points_world_m)


class PingingClock:
    """The mission's clock: as simulated time passes, pings at a steady rate and sends each through the chain."""

    def __init__(
        self, sim: Simulator, chain: ScanChain, log: SurveyLog, ping_interval_s: float, on_ping: Callable[[], None]
    ) -> None:
        self._sim = sim
        self._chain = chain
        self._log = log
        self._steps_between_pings = max(1, round(ping_interval_s / sim.step_s))
        self._steps_to_ping = self._steps_between_pings
        self._on_ping = on_ping

    @property
    def time_s(self) -> float:
        """Simulated seconds since the start."""
        return self._sim.time_s

    def wait(self, duration_s: float) -> None:
        """Let simulated time pass, pinging whenever it is due."""
        steps = round(duration_s / self._sim.step_s)
        while steps > 0:
            now = min(steps, self._steps_to_ping)
            with self._chain.timer.measure("physics"):
                self._sim.step(now)
            steps -= now
            self._steps_to_ping -= now
            if self._steps_to_ping == 0:  # at once, so that the mission's own look is this same ping
                self._ping()

    def _ping(self) -> None:
        self._steps_to_ping = self._steps_between_pings
        rov = self._sim.rov
        with self._chain.timer.measure("rays"):
            ping = rov.sonar.ping()
        points = self._chain.insert(ping.ranges_m, rov.pose.world_from_body, ping.world_from_sonar, self._sim.time_s)
        self._log.note(ping, points)
        self._on_ping()


def fly_survey(
    sim: Simulator,
    occupancy: OccupancyMap | None = None,
    *,
    mission: Callable[[SurveyVehicle, Clock, LawnMowerPlan], Mission] = AdaptiveLawnMower,
    on_progress: Callable[[float], None] = lambda share: None,
    tamper: Callable[[str], str] | None = None,
) -> tuple[OccupancyMap, SurveyRecord]:
    """Fly the scenario's survey to its end, or to Ctrl-C; either way the map of what was seen and the record come back.

    occupancy: the map to fill; by default a new one of the scenario's voxel_m. mission: makes the mission to fly.
    on_progress: called at every ping with the share flown, 0..1. tamper: stands for the channel between sonar and
    decoder; gets each string, returns another.
    Raises ScenarioError when the scenario has no survey.
    """
    survey = required_survey(sim.scenario)
    if occupancy is None:
        occupancy = OccupancyMap(resolution_m=survey.voxel_m)
    log, timer = SurveyLog(np.asarray(survey.area_m)), StageTimer()
    begun, begun_s = time.perf_counter(), sim.time_s
    with ScanChain(
        occupancy, sim.rov.sonar.model.number, _self_box(sim.scenario), threads=sim.threads, timer=timer, tamper=tamper
    ) as chain:
        clock = PingingClock(sim, chain, log, 1.0 / survey.ping_rate_hz, lambda: on_progress(flown.progress))
        flown = mission(sim.rov, clock, _plan(survey))
        try:
            stopped_because = flown.run()
        except KeyboardInterrupt:
            stopped_because = INTERRUPTED
    return occupancy, SurveyRecord(
        scenario_name=sim.scenario.name,
        seed=sim.seed,
        sonar_model=sim.rov.sonar.model.number,
        step_s=sim.step_s,
        voxel_m=occupancy.resolution_m,
        threads=sim.threads,
        stopped_because=stopped_because,
        simulated_s=sim.time_s - begun_s,
        wall_s=time.perf_counter() - begun,
        ping_count=len(log.positions_world_m),
        echo_count=log.echo_count,
        collision_count=sim.rov.collisions,
        path_world_m=np.array(log.positions_world_m).reshape(-1, 3),
        area_world_m=log.area_world_m,
        range_max_m=sim.rov.sonar.model.range_limit_m,
        sample_ping=log.richest,
        stage_wall_s=timer.wall_s,
        ended_early=stopped_because != COVERED,
    )


def required_survey(scenario: Scenario) -> Survey:
    """The scenario's survey. Raises ScenarioError when it has none."""
    if scenario.survey is None:
        raise ScenarioError(
            f"scenario '{scenario.name}': no survey: give it area_m, altitude_m, line_spacing_m, speed_m_s"
        )
    return scenario.survey


def _plan(survey: Survey) -> LawnMowerPlan:
    return LawnMowerPlan(
        area_m=survey.area_m,
        altitude_m=survey.altitude_m,
        line_spacing_m=survey.line_spacing_m,
        speed_m_s=survey.speed_m_s,
        tilt_deg=survey.tilt_deg,
    )


def _self_box(scenario: Scenario) -> SelfBox:
    vertices, _ = vehicle_hull(scenario.vehicles[0].model)
    return SelfBox(vertices.min(axis=0) - SELF_MARGIN_M, vertices.max(axis=0) + SELF_MARGIN_M)
