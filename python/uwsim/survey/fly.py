"""Fly a survey: a mission steers the vehicle, every ping goes through the chain into a map."""

from __future__ import annotations

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
    mission: Callable[[SurveyVehicle, Clock, LawnMowerPlan], Mission] = AdaptiveLawnMower,
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
    resume: flies on from there, given the maps as they were then.
    Raises ScenarioError when the scenario has no survey, ValueError when the flight cannot be resumed.
    """
    survey = required_survey(sim.scenario)
    if occupancy is None:
        occupancy = OccupancyMap(resolution_m=survey.voxel_m)
    begun = time.perf_counter()
    if resume is not None:
        sim.restore_state(resume.simulation)
        begun -= resume.wall_s
    log = resume.log if resume is not None else SurveyLog(np.asarray(survey.area_m))
    begun_s = resume.begun_s if resume is not None else sim.time_s
    timer = StageTimer(resume.stage_wall_s if resume is not None else None)
    with ScanChain(
        occupancy,
        sim.rov.sonar.model.number,
        _self_box(sim.scenario),
        threads=sim.threads,
        timer=timer,
        tamper=tamper,
        reference=reference,
    ) as chain:

        def on_pause() -> None:
            if watch is None:
                return
            stopping = watch.stopping()
            if stopping or watch.save_due():
                chain.when_mapped(partial(save, watch, state()))
            if stopping:
                raise KeyboardInterrupt

        def save(watch: FlightWatch, state: FlightState) -> None:
            with timer.measure(AUTOSAVE):
                watch.save(state, occupancy, reference)

        def state() -> FlightState:
            return FlightState(
                simulation=sim.save_state(),
                mission=flown.save() if isinstance(flown, ResumableMission) else None,
                steps_to_ping=clock.steps_to_ping,
                begun_s=begun_s,
                wall_s=time.perf_counter() - begun,
                stage_wall_s=dict(timer.wall_s),
                log=log.copy(),
            )

        clock = PingingClock(sim, chain, log, 1.0 / survey.ping_rate_hz, lambda: on_progress(flown.progress), on_pause)
        flown = mission(sim.rov, clock, _plan(survey))
        if resume is not None:
            clock.steps_to_ping = resume.steps_to_ping
            _take_up(flown, resume)
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
        path_world_m=log.path_world_m,
        area_world_m=log.area_world_m,
        range_max_m=sim.rov.sonar.model.range_limit_m,
        sample_ping=log.richest,
        stage_wall_s=timer.wall_s,
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
