"""`uwsim run`: fly a mission from a Python file, or resume one."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.base.options import WithoutEffectError, flag_name, need
from uwsim.cli.autopilots import Autopilots, prepared
from uwsim.cli.bounds import readable
from uwsim.cli.flights import (
    Autosave,
    CloseLoops,
    Engine,
    Estimate,
    MapMemory,
    MinCoverage,
    Offsets,
    Out,
    OutlierFilter,
    Raw,
    Report,
    Resume,
    TimeLimit,
    Uncertainty,
    VerifyMap,
    exit_as,
    given,
    require_consistent,
)
from uwsim.cli.groups import under
from uwsim.cli.options import (
    Frequency,
    Link,
    MissionTime,
    Record,
    Seed,
    SonarModel,
    Threads,
    VehicleModel,
    Voxel,
    hertz,
)
from uwsim.cli.options import sonar_model as parsed_sonar_model
from uwsim.cli.values import scenarios

if TYPE_CHECKING:
    from uwsim.flight.record import FlightRecord
    from uwsim.simulator.simulator import Simulator

UNSAVED = "a remote vehicle cannot be put back to where it was, so its flight is neither saved nor resumed"
ALONE = "an autopilot cannot be put back to where it was, so its flight is neither saved nor resumed"


@under("Fly")
def run(
    *,
    mission: Annotated[
        Path | None,
        typer.Argument(
            help="A Python file with `def mission(vehicle): yield ...`.", show_default=False, callback=readable
        ),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(
            help="Name of a packaged scenario, or path of a YAML file. Default: lake. With --connect: the one that "
            "the server flies, to score the map against.",
            autocompletion=scenarios,
        ),
    ] = None,
    out: Out = Path("out"),
    make_map: Annotated[bool, typer.Option("--map", help="Build an OctoMap from the sonar's pings.")] = False,
    voxel: Voxel = None,
    engine: Engine = None,
    verify_map: VerifyMap = False,
    map_memory: MapMemory = None,
    outlier_filter: OutlierFilter = None,
    min_coverage: MinCoverage = None,
    vehicle: Annotated[
        list[str] | None,
        typer.Option(help="Vehicle that flies; may be given several times. Default: the first, or all for `vehicles`."),
    ] = None,
    estimate: Estimate = None,
    close_loops: CloseLoops = False,
    time_limit: TimeLimit = None,
    connect: Annotated[
        str | None,
        typer.Option(help="Fly a vehicle over a rosbridge instead, such as ws://127.0.0.1:9090 of `uwsim serve`."),
    ] = None,
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="With --connect: the simulator is paused while the mission computes.")
    ] = False,
    odometry: Annotated[
        str | None, typer.Option(help="With --connect: the topic of the vehicle's pose. Default: odom.")
    ] = None,
    argument: Annotated[
        list[str] | None, typer.Option("--set", help="NAME=VALUE for another parameter of the mission.")
    ] = None,
    function: Annotated[str | None, typer.Option(help="Name of the mission's function. Default: mission.")] = None,
    seed: Seed = None,
    vehicle_model: VehicleModel = None,
    sonar_model: SonarModel = None,
    frequency: Frequency = None,
    mission_time: MissionTime = None,
    link: Link = None,
    autopilots: Autopilots,
    threads: Threads = None,
    record: Record = None,
    record_topic: Annotated[
        list[str] | None,
        typer.Option(help="Channels to record, such as odom or 'camera/*'. Default: all but pictures and the map."),
    ] = None,
    raw: Raw = None,
    offsets: Offsets = None,
    uncertainty: Uncertainty = None,
    report: Report = "full",
    autosave: Autosave = None,
    resume: Resume = False,
) -> None:
    """Fly a mission from a file; write its log, map and report.

    Ctrl-C ends it early and keeps the results so far. If it is killed, --resume repeats it up to the last saved point,
    without its map, and then continues to the same results.
    """
    autopilot = autopilots.only
    switch = None if autopilot is None else flag_name(str(autopilot.switch))
    of_map = {
        "--voxel": voxel, "--engine": engine, "--verify-map": verify_map or None, "--map-memory": map_memory,
        "--outlier-filter": outlier_filter, "--raw": raw,
        "--close-loops": close_loops or None, "--min-coverage": min_coverage,
    }  # fmt: skip
    simulated = {
        "--estimate": estimate, "--seed": seed, "--vehicle-model": vehicle_model, "--sonar-model": sonar_model,
        "--frequency": frequency, "--mission-time": mission_time, "--link": link, "--threads": threads,
        "--record": record, **({} if switch is None else {switch: True}),
        **{name: value for name, value in of_map.items() if name != "--voxel"},
    }  # fmt: skip
    if mission is None and not resume:
        raise WithoutEffectError("needs the mission's file, such as my_mission.py")
    if switch is not None:
        _refuse({"--autosave": autosave, "--resume": resume or None}, switch, ALONE)
    if connect is None:
        need("--connect", lockstep=lockstep, odometry=odometry)
    else:
        _refuse({"--autosave": autosave, "--resume": resume or None}, "--connect", UNSAVED)
        _refuse(simulated, "--connect", "the server has its own, or there is none")
    if raw is None:
        need("--raw", offsets=offsets, uncertainty=uncertainty)
    if not make_map and not resume:
        need("--map", **{name[2:].replace("-", "_"): value for name, value in of_map.items()})
    if close_loops:
        need("--estimate filter", close_loops=estimate != "filter")
    require_consistent(
        resume=resume, record=record, record_topic=record_topic, close_loops=close_loops, autosave=autosave,
        min_coverage=min_coverage, report=report, raw=raw,
    )  # fmt: skip
    from uwsim.flight.terminal import Terminal

    asked = given(
        function=function, arguments=_arguments(argument or []) or None, vehicles=tuple(vehicle or ()) or None,
        map=make_map or None, voxel_m=voxel, time_limit_s=time_limit, report=report, screen=Terminal(),
    )  # fmt: skip
    of_simulator = given(
        seed=seed, sonar_model=parsed_sonar_model(sonar_model), sonar_frequency_hz=hertz(frequency),
        vehicle_model=vehicle_model, mission_time_s=mission_time, link=link, threads=threads,
    )  # fmt: skip
    of_flight = given(
        estimate=estimate, engine=engine, verify_map=verify_map or None, map_memory_mb=map_memory,
        outlier_filter=outlier_filter, autosave_s=autosave,
    )  # fmt: skip
    flown: FlightRecord
    if connect is not None:
        from uwsim.base.sockets import load

        assert mission is not None
        flown = load("uwsim.flights", "remote")(
            mission, connect, out, odometry=odometry or "odom", lockstep=lockstep, truth=scenario, **asked
        )
    elif resume:
        from uwsim.flight.fly import resume as resume_flight

        flown = resume_flight(out, mission=mission, scenario=scenario, **asked, **of_simulator, **of_flight)
    else:
        from uwsim.flight.fly import fly
        from uwsim.flight.patch_errors import PatchErrors
        from uwsim.scoring.tpu import Uncertainties

        errors = None if offsets is None else PatchErrors.parse(offsets)
        known = None if uncertainty is None else Uncertainties.parse(uncertainty)
        topics = tuple(record_topic or ()) or None
        scene: str | Path | Simulator = scenario or "lake"
        with ExitStack() as stack:
            if autopilot is not None:
                scene, of_simulator = prepared(autopilot, scenario or "lake", **of_simulator), {}
                typer.echo(stack.enter_context(autopilot.flying(scene)))
            flown = fly(
                mission, scene, out, close_loops=close_loops, record=record, record_topics=topics, raw=raw,
                raw_errors=errors, raw_known=known, **asked, **of_simulator, **of_flight,
            )  # fmt: skip
    exit_as(flown, min_coverage)


def _refuse(options: dict[str, Any], by: str, why: str) -> None:
    """Raise WithoutEffectError for an option that was passed although another option makes it useless."""
    if given := [name for name, value in options.items() if value is not None]:
        raise WithoutEffectError(f"{given[0]}: cannot be given with {by}: {why}")


def _arguments(texts: list[str]) -> dict[str, Any]:
    import ast

    from uwsim.flight.mission_file import parsed_arguments

    return parsed_arguments(texts, ast.literal_eval)
