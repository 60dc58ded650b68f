"""Fly a survey: a mission steers the vehicle, every ping goes through the chain into a map."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Protocol

import numpy as np

from uwsim.control.protocols import Clock, SurveyVehicle
from uwsim.mapping import OccupancyMap
from uwsim.missions import COVERED, AdaptiveLawnMower, LawnMowerPlan, Mission, ResumableMission
from uwsim.scenario import Scenario, ScenarioError, Survey, vehicle_hull
from uwsim.simulator import Simulator
from uwsim.survey.chain import ScanChain, SelfBox
from uwsim.survey.clock import PingingClock
from uwsim.survey.flight_state import FlightState
from uwsim.survey.log import SurveyLog
from uwsim.survey.record import INTERRUPTED, SurveyRecord
from uwsim.survey.stages import AUTOSAVE, StageTimer

SELF_MARGIN_M = 0.05
MakeMission = Callable[[SurveyVehicle, Clock, LawnMowerPlan], Mission]


class FlightWatch(Protocol):
    """Looks on whenever the mission waits: may save the flight, or stop it."""

    def save_due(self) -> bool:
        """Whether `save` is wanted now."""

    def save(self, state: FlightState, occupancy: OccupancyMap, reference: OccupancyMap | None) -> None:
        """Keep the state and its maps, which hold every scan until then. May be called by the map's thread."""

    def stopping(self) -> bool:
        """Whether the flight is to end here, as by Ctrl-C. It is saved before."""


def fly_survey(
    sim: Simulator,
    occupancy: OccupancyMap | None = None,
    *,
    mission: MakeMission = AdaptiveLawnMower,
    on_progress: Callable[[float], None] = lambda share: None,
    tamper: Callable[[str], str] | None = None,
    reference: OccupancyMap | None = None,
    watch: FlightWatch | None = None,
    resume: FlightState | None = None,
) -> tuple[OccupancyMap, SurveyRecord]:
    """Fly the scenario's survey to its end, or to Ctrl-C; either way the map of what was seen and the record come back.

    occupancy: the map to fill; by default a new one of the scenario's voxel_m. mission: makes the mission to fly.
    on_progress: called at every ping with the share flown, 0..1. tamper: stands for the channel between sonar and
    decoder; gets each string, returns another. reference: a second map, which gets every scan one by one.
    watch: may save the flight or stop it whenever the mission waits. resume: flies on from there, given the maps as
    they were then.
    Raises ScenarioError when the scenario has no survey, ValueError when the flight cannot be resumed.
    """
    survey = required_survey(sim.scenario)
    if occupancy is None:
        occupancy = OccupancyMap(resolution_m=survey.voxel_m)
    flight = _Flight(sim, occupancy, reference, watch, resume)
    with ScanChain(
        occupancy,
        sim.rov.sonar.model,
        _self_box(sim.scenario),
        threads=sim.threads,
        timer=flight.timer,
        tamper=tamper,
        reference=reference,
    ) as chain:
        stopped_because = flight.fly(chain, mission, survey, on_progress)
    return occupancy, flight.record(stopped_because)


class _Flight:
    """A survey being flown, from its start or from where it was saved."""

    def __init__(
        self,
        sim: Simulator,
        occupancy: OccupancyMap,
        reference: OccupancyMap | None,
        watch: FlightWatch | None,
        resume: FlightState | None,
    ) -> None:
        self._sim, self._occupancy, self._reference = sim, occupancy, reference
        self._watch, self._resume = watch, resume
        self._begun = time.perf_counter()
        if resume is None:
            self._begun_s, self._log = sim.time_s, SurveyLog(np.asarray(required_survey(sim.scenario).area_m))
            self.timer = StageTimer()
        else:
            sim.restore_state(resume.simulation)
            self._begun -= resume.wall_s
            self._begun_s, self._log = resume.begun_s, resume.log
            self.timer = StageTimer(resume.stage_wall_s)

    def fly(
        self, chain: ScanChain, make_mission: MakeMission, survey: Survey, on_progress: Callable[[float], None]
    ) -> str:
        """Returns what ended it."""
        self._chain = chain
        self._clock = PingingClock(
            self._sim,
            chain,
            self._log,
            _ping_interval_s(self._sim, survey),
            lambda: on_progress(self._mission.progress),
            self._on_pause,
        )
        self._mission = make_mission(self._sim.rov, self._clock, _plan(survey))
        if self._resume is not None:
            self._clock.steps_to_ping = self._resume.steps_to_ping
            _take_up(self._mission, self._resume)
        try:
            return self._mission.run()
        except KeyboardInterrupt:
            return INTERRUPTED

    def _on_pause(self) -> None:
        if self._watch is None:
            return
        stopping = self._watch.stopping()
        if stopping or self._watch.save_due():
            self._chain.when_mapped(partial(self._save, self._watch, self._state()))
        if stopping:
            raise KeyboardInterrupt

    def _save(self, watch: FlightWatch, state: FlightState) -> None:
        with self.timer.measure(AUTOSAVE):
            watch.save(state, self._occupancy, self._reference)

    def _state(self) -> FlightState:
        return FlightState(
            simulation=self._sim.save_state(),
            mission=self._mission.save() if isinstance(self._mission, ResumableMission) else None,
            steps_to_ping=self._clock.steps_to_ping,
            begun_s=self._begun_s,
            wall_s=time.perf_counter() - self._begun,
            stage_wall_s=dict(self.timer.wall_s),
            log=self._log.copy(),
        )

    def record(self, stopped_because: str) -> SurveyRecord:
        """What the survey hands over, its map apart."""
        sim, log = self._sim, self._log
        survey = required_survey(sim.scenario)
        return SurveyRecord(
            scenario_name=sim.scenario.name,
            seed=sim.seed,
            sonar_model=sim.scenario.vehicles[0].sonar.title,
            step_s=sim.step_s,
            voxel_m=self._occupancy.resolution_m,
            threads=sim.threads,
            stopped_because=stopped_because,
            simulated_s=sim.time_s - self._begun_s,
            wall_s=time.perf_counter() - self._begun,
            ping_count=len(log.positions_world_m),
            echo_count=log.echo_count,
            collision_count=sim.rov.collisions,
            path_world_m=log.path_world_m,
            area_world_m=log.area_world_m,
            range_max_m=sim.rov.sonar.model.range_limit_m,
            ping_interval_s=_ping_interval_s(sim, survey),
            ping_interval_asked_s=1.0 / survey.ping_rate_hz,
            sample_ping=log.richest,
            stage_wall_s=self.timer.wall_s,
            ended_early=stopped_because != COVERED,
        )


def _take_up(flown: Mission, state: FlightState) -> None:
    if state.mission is None or not isinstance(flown, ResumableMission):
        raise ValueError(f"mission {type(flown).__name__}: cannot be resumed: it has no save and restore")
    flown.restore(state.mission)


def required_survey(scenario: Scenario) -> Survey:
    """The scenario's survey. Raises ScenarioError when it has none."""
    if scenario.survey is None:
        raise ScenarioError(
            f"scenario '{scenario.name}': no survey: give it area_m, altitude_m, line_spacing_m, speed_m_s"
        )
    return scenario.survey


def _ping_interval_s(sim: Simulator, survey: Survey) -> float:
    """The scenario's, or what two-way travel time allows where that is longer; whole steps."""
    least_s = 1.0 / sim.rov.sonar.ping_rate_max_hz
    return max(1.0 / survey.ping_rate_hz, math.ceil(least_s / sim.step_s) * sim.step_s)


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
