"""fly: fly a mission in a simulator, with log, samples, map and report. `uwsim run` calls it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from uwsim.base.folder_lock import alone_in, require_free
from uwsim.flight.attached import attached
from uwsim.flight.attachment import Attachments, Departure
from uwsim.flight.clock import AUTOSAVE_S, FlightAutosave
from uwsim.flight.engine import Flight
from uwsim.flight.folder import remove_leftovers, results_folder
from uwsim.flight.mission_file import FUNCTION
from uwsim.flight.missions import AnyMission, FlownMission, found_mission
from uwsim.flight.pinging import MapSetup, default_voxel_m, filters_outliers, require_sonar, survey_area_m
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import (
    ESTIMATES,
    OF_SIMULATOR,
    EstimateKind,
    FlightRequest,
    file_digest,
    resolved_path,
    with_survey,
)
from uwsim.flight.results import require_report
from uwsim.flight.setup import Setup
from uwsim.flight.terminal import Silent
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.missions.run import R_co
from uwsim.scenario import AnyScenario, Scenario, Survey, load
from uwsim.scenario.read.validated import validated
from uwsim.scoring.true_surface import SurfaceAhead
from uwsim.simulator.simulator import Simulator


def fly(
    mission: AnyMission[R_co],
    scenario: AnyScenario | Simulator = "lake",
    out: str | Path | None = None,
    *,
    function: str = FUNCTION,
    arguments: Mapping[str, Any] | None = None,
    vehicles: Iterable[str] = (),
    estimate: EstimateKind = "truth",
    map: bool = False,  # noqa: A002  # named like the command-line option
    voxel_m: float | None = None,
    engine: MapEngine | None = None,
    verify_map: bool = False,
    map_growth: bool = True,
    sample_sensors: bool = True,
    outlier_filter: bool | None = None,
    seed: int | None = None,
    sonar_model: int | str | None = None,
    sonar_frequency_hz: float | None = None,
    vehicle_model: str | Path | None = None,
    mission_time_s: float | None = None,
    link: str | Path | None = None,
    survey: Mapping[str, Any] | None = None,
    carried: tuple[str, ...] | None = None,
    time_limit_s: float | None = None,
    threads: int | None = None,
    report: str = "full",
    autosave_s: float = AUTOSAVE_S,
    autosave: FlightAutosave | None = None,
    screen: Silent | None = None,
    **attachments: Any,
) -> FlightRecord[R_co]:
    """Fly a mission; return its record.

        record = fly(mission, scenario="pool")                       # a function, as in a notebook
        record = fly("my_mission.py", "lake", "out/", map=True)      # a file; results in a folder

    mission: see found_mission; if None, the scenario's survey. scenario: a name, a path, a Scenario, the content of a
    scenario's file, or a Simulator, which continues from its current state. out: folder for log.jsonl,
    track-VEHICLE.csv and map.bt. report: "full" also writes summary.json and report.html, "json" only summary.json,
    "none" neither. function: name of the mission function, if the mission is a file. arguments: values for the
    mission's other parameters. vehicles: names; by default all if the mission takes `vehicles`, else the first.
    estimate: source of the poses that the mission and the map use: "truth", or "filter" (Vehicle.estimate).
    mission_time_s: battery life. time_limit_s: limit in simulated time; by default the battery life. link: a modem, by
    name or file, that replaces the scenario's; the map built ashore from the pings that arrive is written to
    map_ashore.bt. survey: values that replace those of the scenario's survey, by key. carried: name endings of the
    channels that vehicles send over the link; by default all that the link can carry. sample_sensors: whether the
    record's samples include the readings of all sensors. autosave_s: wall time between saves of the map; 0 disables
    them. screen: displays the flight; by default nothing is displayed. With a Terminal, Ctrl-C
    ends the flight and keeps its results.

    attachments: options of what takes part in the flight, named as the flags of `uwsim run`: record (path of a new
    recording), record_topic; raw (path of a new file with each mapped ping of the first vehicle), offsets, uncertainty;
    and those of other packages, see uwsim.flight.attachment.

    Map options: engine is "bricks" by default. verify_map also inserts every scan into a stock OctoMap and compares the
    two maps byte for byte. map_growth measures the map as it grows. outlier_filter overrides the scenario's setting.

    Raises ScenarioError or ValueError for invalid arguments, before anything is written; OSError if results cannot be
    written; and the mission's own errors, as MissionError if the mission is a file, after the results so far have been
    written.
    """
    of_map = {
        "voxel_m": voxel_m, "engine": engine, "verify_map": verify_map or None,
        "outlier_filter": outlier_filter,
    }  # fmt: skip
    if isinstance(scenario, Mapping):
        scenario = load(scenario)
    _require_consistent(estimate, report, map, of_map, time_limit_s)
    begun_with = scenario
    if survey and not isinstance(scenario, Simulator):
        scenario = with_survey(scenario, survey)
    elif survey:
        raise ValueError("survey: has no effect on an existing simulator")
    screen = screen or Silent()
    saving = autosave or _autosave(autosave_s, screen)
    options = Attachments(**attachments)
    found = found_mission(mission, function, arguments)
    if out is not None:
        require_free(Path(out))
    of_simulator = {
        "seed": seed, "sonar_model": sonar_model, "sonar_frequency_hz": sonar_frequency_hz,
        "vehicle_model": vehicle_model, "mission_time_s": mission_time_s, "link": link, "threads": threads,
    }  # fmt: skip
    sim = _simulator(scenario, of_simulator, screen)
    names = tuple(vehicles) or (tuple(sim.vehicles) if found.flies_all else (sim.rov.name,))
    found = found.bound(sim, names, None if out is None else Path(out))
    plan, left_out = found.planned(sim)
    _require_able(sim, found, names, estimate, map, outlier_filter)
    request = FlightRequest(
        mission=None if found.file is None else str(found.file.resolve()),
        function=function,
        mission_digest=None if found.file is None else file_digest(found.file),
        arguments=dict(arguments or {}),
        scenario=str(resolved_path(begun_with)) if isinstance(begun_with, str | Path) else "",
        survey=dict(survey or {}),
        **{name: resolved_path(of_simulator[name]) for name in OF_SIMULATOR} | {"seed": sim.seed},
        carried=carried,
        vehicles=names,
        estimate=estimate,
        map=map,
        voxel_m=_checked_voxel_m(sim, voxel_m) if map else None,
        engine=engine or "bricks",
        verify_map=verify_map,
        outlier_filter=outlier_filter,
        map_growth=map_growth,
        sample_sensors=sample_sensors,
        time_limit_s=time_limit_s,
    )
    if found.file is None:
        request = replace(request, mission=found.name)
    taking_part = attached(options, Departure(sim, names, found.make is not None, map, request, carried))
    setup = Setup(
        sim=sim, mission=found, names=names, estimate=estimate, time_limit_s=time_limit_s,
        plan=plan, lanes_left_out=left_out, attachments=taking_part, sample_sensors=sample_sensors,
        out=None if out is None else results_folder(Path(out), names),
        report=report, autosave=saving, screen=screen,
    )  # fmt: skip
    if map:
        occupancy = OccupancyMap(resolution_m=request.voxel_m or 1.0, engine=request.engine)
        setup.mapping = replace(
            _map_setup(sim, request, occupancy, request.new_reference(), report),
            on_ping=tuple(each.on_ping for each in taking_part.values() if each.on_ping is not None),
        )  # fmt: skip
    if setup.out is None:
        return Flight(setup).run()
    with alone_in(setup.out):
        remove_leftovers(setup.out)
        return Flight(setup).run()


def _autosave(interval_s: float, screen: Silent) -> FlightAutosave:
    return FlightAutosave(interval_s, screen.message, handles_signals=screen.handles_signals)


def _map_setup(
    sim: Simulator, request: FlightRequest, occupancy: OccupancyMap, reference: OccupancyMap | None, report: str
) -> MapSetup:
    area_m = survey_area_m(sim)
    ahead = None
    if report != "none" and area_m is not None:
        ahead = SurfaceAhead(sim.world, sim.scene, occupancy.resolution_m, area_m)
    return MapSetup(occupancy, reference, request.outlier_filter, growth=request.map_growth, ahead=ahead)


def _require_consistent(
    estimate: str, report: str, makes_map: bool, of_map: Mapping[str, Any], time_limit_s: float | None
) -> None:
    """Raise ValueError if arguments contradict each other or would have no effect."""
    if estimate not in ESTIMATES:
        raise ValueError(f"estimate = {estimate!r}: must be one of {', '.join(ESTIMATES)}")
    require_report(report)
    if not makes_map and (given := [name for name, value in of_map.items() if value is not None]):
        raise ValueError(f"{given[0]} = {of_map[given[0]]}: has no effect unless map=True")
    if time_limit_s is not None and not 0.0 < time_limit_s < math.inf:
        raise ValueError(f"time_limit_s = {time_limit_s} s: must be positive")


def _simulator(scenario: str | Path | Scenario | Simulator, given: Mapping[str, Any], screen: Silent) -> Simulator:
    if isinstance(scenario, Simulator):
        if ignored := [name for name, value in given.items() if value is not None]:
            raise ValueError(f"{ignored[0]}: has no effect on an existing simulator")
        sim = scenario
        sim.scene.prepare()
    else:
        with screen.status(f"building {scenario if isinstance(scenario, str | Path) else scenario.name}"):
            sim = Simulator(scenario, **given)
            sim.scene.prepare()  # before anything is written, in case memory is short
    return sim


def _require_able(
    sim: Simulator, mission: FlownMission, names: tuple[str, ...], estimate: EstimateKind, makes_map: bool,
    outlier_filter: bool | None,
) -> None:  # fmt: skip
    """Raise ValueError unless the vehicles can fly this mission."""
    if mission.make is not None and len(names) > 1:
        raise ValueError(f"vehicles = {', '.join(names)}: {mission.title} flies one vehicle")
    for name in names:
        vehicle = sim.vehicles[name]  # raises ValueError for an unknown name
        if makes_map:
            require_sonar(sim.scenario, name)
            filters_outliers(sim, name, outlier_filter)
        if estimate == "filter":
            _ = vehicle.navigation.steering  # raises ValueError for a vehicle without an IMU


def _checked_voxel_m(sim: Simulator, voxel_m: float | None) -> float:
    """Return the map's voxel size.

    Raises ScenarioError for a value that would be invalid in a scenario's survey.
    """
    if voxel_m is None:
        return default_voxel_m(sim)
    if sim.scenario.survey is None:
        return voxel_m
    return validated(Survey, {**dict(sim.scenario.survey), "voxel_m": voxel_m}).voxel_m
