"""run_survey and fly_survey: map a scenario's survey area, by default by flying parallel lanes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from uwsim.flight.attached import attached
from uwsim.flight.attachment import Attachments, Departure
from uwsim.flight.engine import Flight
from uwsim.flight.fly import fly
from uwsim.flight.flyable_lanes import LEAST_SHARE, required_survey
from uwsim.flight.missions import AnyMission, found_mission
from uwsim.flight.pinging import SURVEYED, MapSetup, TakePing, filters_outliers
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import EstimateKind, with_survey
from uwsim.flight.setup import Setup
from uwsim.flight.terminal import Silent, Terminal
from uwsim.mapping import OccupancyMap
from uwsim.scenario import AnyScenario, load
from uwsim.simulator.simulator import Simulator


def run_survey(
    scenario: AnyScenario = "lake",
    out: str | Path = "out",
    *,
    mission: AnyMission = None,
    screen: Silent | None = None,
    **options: Any,
) -> FlightRecord:
    """Fly a scenario's survey and write map.bt, report.html, summary.json and figures into `out`; return its record.

        record = uwsim.run_survey("pool", "out/", report="json")
        print(record.coverage, record.simulated_s)

    Like `fly`, but builds a map and prints progress; on Ctrl-C it stops and keeps the map built so far. mission: by
    default, the adaptive lawn-mower over the survey area. options: the other arguments of `fly`. Raises ScenarioError
    or ValueError for an error in the scenario or the arguments, OSError if `out` cannot be written. The map is written
    even if the mission fails.
    """
    required_survey(
        with_survey(scenario, options["survey"]) if options.get("survey") else load(scenario)
    )  # before building the world
    return fly(
        mission,
        scenario,
        out,
        map=True,
        map_growth=False,
        sample_sensors=False,
        carried=SURVEYED,
        screen=screen or Terminal(),
        **options,
    )


def fly_survey(
    sim: Simulator,
    occupancy: OccupancyMap | None = None,
    *,
    mission: AnyMission = None,
    on_progress: Callable[[float], None] | None = None,
    transmit: Callable[[str], str] | None = None,
    outlier_filter: bool | None = None,
    on_ping_taken: TakePing | None = None,
    estimate: EstimateKind = "truth",
    least_share: float = LEAST_SHARE,
) -> tuple[OccupancyMap, FlightRecord]:
    """Fly the scenario's survey without writing files, until it ends or Ctrl-C stops it; return the map and the record.

    occupancy: the map to fill; by default a new map with the scenario's voxel_m. mission: see found_mission.
    on_progress: called at every ping with the share flown, 0 to 1. transmit: see depth_string. outlier_filter: see
    filters_outliers. on_ping_taken: called with every ping. estimate: "filter" flies and maps with the poses of
    Vehicle.estimate. least_share: share of the lanes that must be flyable. Raises ScenarioError if the scenario has no
    survey, or less than least_share of its lanes can be flown. Otherwise lanes that cannot be flown are left out, with
    a SurveyAreaWarning.
    """
    survey = required_survey(sim.scenario)
    filters_outliers(sim, sim.rov.name, outlier_filter)
    if occupancy is None:
        occupancy = OccupancyMap(resolution_m=survey.voxel_m)
    sim.scene.prepare()
    found = found_mission(mission)
    plan, left_out = found.planned(sim, least_share)
    names = (sim.rov.name,)
    departure = Departure(sim, names, found.make is not None, has_map=True, carried=SURVEYED)
    setup = Setup(
        sim=sim, mission=found, names=names, estimate=estimate, plan=plan, lanes_left_out=left_out,
        attachments=attached(Attachments(), departure), sample_sensors=False,
    )  # fmt: skip
    flight = Flight(setup)
    on_ping = () if on_ping_taken is None else (on_ping_taken,)
    if on_progress is not None:
        on_ping = (*on_ping, lambda ping, panel, body: on_progress(flight.progress or 0.0))
    setup.mapping = MapSetup(occupancy, outlier_filter=outlier_filter, transmit=transmit, growth=False, on_ping=on_ping)
    return occupancy, flight.run()
