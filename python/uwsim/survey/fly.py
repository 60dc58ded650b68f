"""Flies a survey: a mission steers the vehicle, and every ping passes through the chain into a map."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.control.protocols import Clock, SurveyVehicle
from uwsim.mapping import OccupancyMap
from uwsim.missions import COVERED, AdaptiveLawnMower, LawnMowerPlan, Mission, ResumableMission
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.scenario import Scenario, ScenarioError, Survey, vehicle_hull
from uwsim.scoring.surface_ahead import SurfaceAhead
from uwsim.simulator import Simulator
from uwsim.survey.flight_state import FlightState
from uwsim.survey.flyable_lanes import LEAST_SHARE, SurveyAreaWarning, flyable_plan
from uwsim.survey.ping_log import PingLog
from uwsim.survey.ping_to_map import HullBox, PingToMap
from uwsim.survey.pinging_clock import PingingClock, TakePing
from uwsim.survey.record import INTERRUPTED, EstimateKind, SurveyRecord
from uwsim.survey.wall_time import AUTOSAVE, WallTimer

if TYPE_CHECKING:
    from uwsim.survey.ashore import Ashore

HULL_MARGIN_M = 0.05
MakeMission = Callable[[SurveyVehicle, Clock, LawnMowerPlan], Mission]


class FlightSupervisor(Protocol):
    """Called whenever the mission waits: may save the flight or stop it."""

    def save_due(self) -> bool:
        """Whether to call `save` now."""

    def save(self, state: FlightState, occupancy: OccupancyMap, reference: OccupancyMap | None) -> None:
        """Save the state and its maps, which hold every scan until then. May be called on the map's thread."""

    def stop_requested(self) -> bool:
        """Whether to end the flight here, as by Ctrl-C; `save` is called first."""


def fly_survey(
    sim: Simulator,
    occupancy: OccupancyMap | None = None,
    *,
    mission: MakeMission = AdaptiveLawnMower,
    on_progress: Callable[[float], None] = lambda share: None,
    transmit: Callable[[str], str] | None = None,
    reference: OccupancyMap | None = None,
    supervisor: FlightSupervisor | None = None,
    resume: FlightState | None = None,
    outlier_filter: bool | None = None,
    on_ping_taken: TakePing | None = None,
    estimate: EstimateKind = "truth",
    least_share: float = LEAST_SHARE,
    ahead: SurfaceAhead | None = None,
) -> tuple[OccupancyMap, SurveyRecord]:
    """Fly the scenario's survey to its end or to Ctrl-C; returns the map and the record in both cases.

    occupancy: the map to fill; by default a new one with the scenario's voxel_m. mission: makes the mission to fly.
    on_progress: called at every ping with the share flown, 0 to 1. transmit: simulates the channel between sonar and
    decoder; receives each depth string and returns the string that arrives. reference: a second map, which gets every
    scan one by one. supervisor: may save or stop the flight whenever the mission waits. resume: a saved flight to
    continue; `occupancy` and `reference` must be the maps that were saved with it.
    outlier_filter: see filters_outliers. estimate: "filter" flies and maps by Vehicle.estimate. on_ping_taken: called
    with each ping, the panel and the body's pose as the map was told it. least_share: of the lanes, which must be
    flyable. ahead: looks at the true surface while the map's thread has nothing else to do, so that the map is scored
    sooner.
    Raises ScenarioError when the scenario has no survey, or most of its lanes cannot be flown, ValueError when the
    flight cannot be resumed. Fewer such lanes are left out, with a SurveyAreaWarning.
    """
    survey = required_survey(sim.scenario)
    if occupancy is None:
        occupancy = OccupancyMap(resolution_m=survey.voxel_m)
    filters = filters_outliers(sim, outlier_filter)
    flight = _Flight(sim, occupancy, reference, supervisor, resume, on_ping_taken, estimate, least_share)
    look_at = None if ahead is None else ahead.look_at
    with chain_of(sim, occupancy, filters, flight.timer, transmit, reference, look_at) as chain:
        stopped_because = flight.fly(chain, mission, survey, on_progress)
    return occupancy, replace(flight.record(stopped_because), outlier_filter=filters)


def chain_of(
    sim: Simulator,
    occupancy: OccupancyMap,
    filters: bool,
    timer: WallTimer | None = None,
    transmit: Callable[[str], str] | None = None,
    reference: OccupancyMap | None = None,
    on_mapped: Callable[[NDArray[np.float32]], None] | None = None,
) -> PingToMap:
    """Return the chain from the surveying vehicle's pings to a map. filters: whether outliers are discarded."""
    return PingToMap(
        occupancy,
        sim.rov.sonar.model,
        hull_box(sim.scenario),
        threads=sim.threads,
        timer=timer,
        transmit=transmit,
        reference=reference,
        outlier_filter=filters,
        max_uncertainty_m=_max_uncertainty_m(sim, occupancy) if filters else None,
        on_mapped=on_mapped,
    )


class _Flight:
    """A survey in flight, begun now or resumed from a saved state."""

    def __init__(
        self,
        sim: Simulator,
        occupancy: OccupancyMap,
        reference: OccupancyMap | None,
        supervisor: FlightSupervisor | None,
        resume: FlightState | None,
        on_ping_taken: TakePing | None = None,
        estimate: EstimateKind = "truth",
        least_share: float = LEAST_SHARE,
    ) -> None:
        self._on_ping_taken, self._estimate_kind, self._least_share = on_ping_taken, estimate, least_share
        self._sim, self._occupancy, self._reference = sim, occupancy, reference
        self._supervisor, self._resume = supervisor, resume
        self._wall_start_s = time.perf_counter()
        if resume is None:
            self._begun_s, self._log = sim.time_s, PingLog(np.asarray(required_survey(sim.scenario).area_m))
            self.timer = WallTimer()
        else:
            sim.restore_state(resume.simulation)
            self._wall_start_s -= resume.wall_s
            self._begun_s, self._log = resume.begun_s, resume.log
            self.timer = WallTimer(resume.stage_wall_s)
        self._ashore: Ashore | None = None
        if sim.link is not None:
            from uwsim.survey.ashore import Ashore  # here, since channels take long to import

            self._ashore = Ashore(sim, None if resume is None else resume.ashore)

    def fly(
        self, chain: PingToMap, make_mission: MakeMission, survey: Survey, on_progress: Callable[[float], None]
    ) -> str:
        """Fly the mission; returns the reason why it ended."""
        self._chain, rov = chain, self._sim.rov
        estimate = rov.estimate if self._estimate_kind == "filter" else None
        self._clock = PingingClock(
            self._sim,
            chain,
            self._log,
            ping_interval_s(self._sim, survey),
            lambda: self._on_ping(on_progress),
            self._on_pause,
            self._on_ping_taken,
            estimate,
        )
        plan, self._left_out = flyable_plan(self._sim, survey_plan(survey), self._least_share)
        if self._left_out is not None:
            warnings.warn(self._left_out, SurveyAreaWarning, stacklevel=3)
        self._mission = make_mission(
            rov if estimate is None else OwnVehicle(rov, self._clock, estimate=estimate), self._clock, plan
        )
        if self._resume is not None:
            self._clock.steps_to_ping = self._resume.steps_to_ping
            _restore_mission(self._mission, self._resume)
        try:
            return self._mission.run()
        except KeyboardInterrupt:
            return INTERRUPTED
        finally:
            if self._ashore is not None:
                self._ashore.close()

    def _on_ping(self, on_progress: Callable[[float], None]) -> None:
        if self._ashore is not None:
            self._ashore.listen()
        on_progress(self._mission.progress)

    def _on_pause(self) -> None:
        if self._supervisor is None:
            return
        stop = self._supervisor.stop_requested()
        if stop or self._supervisor.save_due():
            self._chain.when_mapped(partial(self._save, self._supervisor, self._state()))
        if stop:
            raise KeyboardInterrupt

    def _save(self, supervisor: FlightSupervisor, state: FlightState) -> None:
        with self.timer.measure(AUTOSAVE):
            supervisor.save(state, self._occupancy, self._reference)

    def _state(self) -> FlightState:
        return FlightState(
            simulation=self._sim.save_state(),
            mission=self._mission.save() if isinstance(self._mission, ResumableMission) else None,
            steps_to_ping=self._clock.steps_to_ping,
            begun_s=self._begun_s,
            wall_s=time.perf_counter() - self._wall_start_s,
            stage_wall_s=dict(self.timer.wall_s),
            log=self._log.copy(),
            ashore=None if self._ashore is None else self._ashore.save(),
        )

    def record(self, stopped_because: str) -> SurveyRecord:
        """Return the record of the flight so far."""
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
            wall_s=time.perf_counter() - self._wall_start_s,
            ping_count=len(log.positions_world_m),
            echo_count=log.echo_count,
            collision_count=sim.rov.collisions,
            path_world_m=log.path_world_m,
            area_world_m=log.area_world_m,
            range_max_m=sim.rov.sonar.model.range_limit_m,
            ping_interval_s=ping_interval_s(sim, survey),
            ping_interval_requested_s=1.0 / survey.ping_rate_hz,
            sample_ping=log.sample,
            stage_wall_s=self.timer.wall_s,
            ended_early=stopped_because != COVERED,
            lanes_left_out=self._left_out,
            estimate=self._estimate_kind,
            position_error_m=np.array(log.position_error_m),
            pings_with_warning=dict(log.pings_with_warning),
            warning_limits_m=_warning_limits_m(sim.scenario),
            ashore=self._ashore,
        )


def _restore_mission(mission: Mission, state: FlightState) -> None:
    if state.mission is None or not isinstance(mission, ResumableMission):
        raise ValueError(f"mission {type(mission).__name__}: cannot be resumed: it has no save and restore")
    mission.restore(state.mission)


def required_survey(scenario: Scenario) -> Survey:
    """Return the scenario's survey. Raises ScenarioError when it has none."""
    if scenario.survey is None:
        raise ScenarioError(
            f"scenario '{scenario.name}': no survey: give it area_m, altitude_m, line_spacing_m, speed_m_s"
        )
    return scenario.survey


def filters_outliers(sim: Simulator, asked: bool | None) -> bool:
    """Whether outliers are filtered: as asked, else as the scenario says, else in the sonar's physics mode.

    Raises ScenarioError if the scenario limits uncertainties that the sonar does not know.
    """
    survey, in_physics = required_survey(sim.scenario), sim.rov.sonar.mode == "physics"
    if survey.max_uncertainty_m is not None and not in_physics:
        with sim.scenario.source_file.errors_at("survey", "max_uncertainty_m"):
            raise ScenarioError(
                f"survey.max_uncertainty_m = {survey.max_uncertainty_m:g} m: needs a sonar with `mode: physics`"
            )
    if asked is None:
        asked = survey.outlier_filter
    return in_physics if asked is None else asked


def _max_uncertainty_m(sim: Simulator, occupancy: OccupancyMap) -> float | None:
    """Return the limit of the echoes' uncertainty: the scenario's, else half a voxel; None where it is not known."""
    if sim.rov.sonar.mode != "physics":
        return None
    asked_m = required_survey(sim.scenario).max_uncertainty_m
    return occupancy.resolution_m / 2.0 if asked_m is None else asked_m


def ping_interval_s(sim: Simulator, survey: Survey) -> float:
    """Return the scenario's ping interval, or the two-way travel time in whole steps where that is longer."""
    least_s = 1.0 / sim.rov.sonar.ping_rate_max_hz
    return max(1.0 / survey.ping_rate_hz, math.ceil(least_s / sim.step_s) * sim.step_s)


def survey_plan(survey: Survey) -> LawnMowerPlan:
    """Return the plan of the scenario's survey."""
    return LawnMowerPlan(
        area_m=survey.area_m,
        altitude_m=survey.altitude_m,
        line_spacing_m=survey.line_spacing_m,
        speed_m_s=survey.speed_m_s,
        tilt_deg=survey.tilt_deg,
    )


def _warning_limits_m(scenario: Scenario) -> dict[str, float]:
    return {"range": scenario.warnings.range_m, "proximity": scenario.warnings.proximity_m}


def hull_box(scenario: Scenario) -> HullBox:
    """Return the box about the surveying vehicle's hull."""
    vertices, _ = vehicle_hull(scenario.vehicles[0].model)
    return HullBox(vertices.min(axis=0) - HULL_MARGIN_M, vertices.max(axis=0) + HULL_MARGIN_M)
