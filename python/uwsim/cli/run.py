"""`uwsim run`: fly a mission from a Python file, or resume one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from uwsim.cli.bounds import readable, within
from uwsim.cli.choices import one_of
from uwsim.cli.exit_codes import INCOMPLETE, INTERRUPTED, STUCK
from uwsim.cli.options import Link, MissionTime, Record, Seed, SonarModel, Threads, Voxel, WithoutEffectError, need
from uwsim.cli.options import sonar_model as parsed_sonar_model
from uwsim.cli.values import scenarios

UNSAVED = "a remote vehicle cannot be put back to where it was, so its flight is neither saved nor resumed"


def run(
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
    out: Annotated[Path, typer.Option(help="Folder for log.jsonl, report.html, track-VEHICLE.csv and map.bt.")] = Path(
        "out"
    ),
    make_map: Annotated[bool, typer.Option("--map", help="Make an OctoMap of what the sonar sees.")] = False,
    voxel: Voxel = None,
    vehicle: Annotated[
        list[str] | None,
        typer.Option(help="Vehicle that flies; may be given several times. Default: the first, or all for `vehicles`."),
    ] = None,
    estimate: Annotated[
        str | None,
        typer.Option(
            help="What vehicles know of their pose, and maps are made with: truth (default), or filter.",
            **one_of("truth", "filter"),
        ),
    ] = None,
    close_loops: Annotated[
        bool,
        typer.Option(
            "--close-loops",
            help="With --map --estimate filter: bend the track after the flight until what was seen twice fits, and "
            "make the map again.",
        ),
    ] = False,
    time_limit: Annotated[
        float | None,
        typer.Option(
            help="End the flight after this simulated time [s]. Default: the battery's.",
            callback=within(0.001, 1e9, "s"),
        ),
    ] = None,
    connect: Annotated[
        str | None,
        typer.Option(help="Fly a vehicle at a rosbridge, such as ws://127.0.0.1:9090 of `uwsim serve`, instead."),
    ] = None,
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="With --connect: the simulator stands still while the mission thinks.")
    ] = False,
    odometry: Annotated[
        str | None, typer.Option(help="With --connect: the topic of the vehicle's pose. Default: odom.")
    ] = None,
    argument: Annotated[
        list[str] | None, typer.Option("--set", help="NAME=VALUE for another parameter of the mission.")
    ] = None,
    function: Annotated[str | None, typer.Option(help="Name of the mission's function. Default: mission.")] = None,
    seed: Seed = None,
    sonar_model: SonarModel = None,
    mission_time: MissionTime = None,
    link: Link = None,
    threads: Threads = None,
    record: Record = None,
    record_topic: Annotated[
        list[str] | None,
        typer.Option(help="Channels to record, such as odom or 'camera/*'. Default: all but pictures and the map."),
    ] = None,
    report: Annotated[
        str,
        typer.Option(
            help="full: report.html, figures and summary.json; json: summary.json alone; none: neither.",
            **one_of("full", "json", "none"),
        ),
    ] = "full",
    autosave: Annotated[
        float | None,
        typer.Option(help="Wall time between saves [s]; 0 for none. Default: 30.", callback=within(0, 1e6, "s")),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue the flight last saved in --out.")] = False,
) -> None:
    """Fly a mission from a Python file; log, map and report it.

    Ctrl-C ends it early and keeps what there is. If it is killed, --resume flies it again as far as it was, without
    its map, and then continues to the same results.
    """
    from uwsim.flight.autosave import FlightAutosave
    from uwsim.flight.fly import fly
    from uwsim.flight.fly import resume as resume_flight
    from uwsim.flight.terminal import print_flight
    from uwsim.survey.terminal import Terminal

    simulated = {
        "--estimate": estimate, "--seed": seed, "--sonar-model": sonar_model,
        "--mission-time": mission_time, "--link": link, "--threads": threads,
        "--record": record, "--autosave": autosave, "--close-loops": close_loops or None,
    }  # fmt: skip
    ours = {
        "the mission": mission, "--connect": connect, "--map": make_map or None, "--voxel": voxel, "--vehicle": vehicle,
        "--time-limit": time_limit, "--set": argument, "--function": function, "--scenario": scenario,
        **simulated,
    }  # fmt: skip
    if resume:
        kept = {name: value for name, value in ours.items() if name not in ("--threads", "--autosave")}
        _refuse(kept, "--resume", "the saved flight has its own")
    elif mission is None:
        raise WithoutEffectError("needs the mission's file, such as my_mission.py")
    if connect is None:
        need("--connect", lockstep=lockstep, odometry=odometry)
    else:
        _refuse({"--autosave": simulated.pop("--autosave")}, "--connect", UNSAVED)
        _refuse(simulated, "--connect", "the server has its own, or there is none")
    if not make_map and not resume:
        need("--map", voxel=voxel, close_loops=close_loops)
    if close_loops:
        need("--estimate filter", close_loops=estimate != "filter")
        _refuse({"--autosave": autosave or None}, "--close-loops", "such a flight is not saved as it flies")
    if record is None:
        need("--record", record_topic=record_topic)
    estimate, odometry, function = estimate or "truth", odometry or "odom", function or "mission"
    screen = Terminal()
    saving = FlightAutosave(30.0 if autosave is None else autosave, screen.message, hears_signals=True)
    if resume:
        flown = resume_flight(out, threads=threads, report=report, autosave=saving, show=screen.status)
    elif connect is not None:
        from uwsim.flight.remote import fly_remote

        assert mission is not None
        flown = fly_remote(
            mission,
            connect,
            out,
            function=function,
            arguments=_arguments(argument or []),
            vehicles=vehicle or (),
            odometry=odometry,
            lockstep=lockstep,
            map=make_map,
            voxel_m=voxel,
            time_limit_s=time_limit,
            truth=scenario,
            report=report,
            autosave=saving,
            show=screen.status,
        )
    else:
        assert mission is not None
        flown = fly(
            mission,
            scenario or "lake",
            out,
            function=function,
            arguments=_arguments(argument or []),
            vehicles=vehicle or (),
            estimate=estimate,  # type: ignore[arg-type]  # checked there
            map=make_map,
            voxel_m=voxel,
            close_loops=close_loops,
            seed=seed,
            sonar_model=parsed_sonar_model(sonar_model),
            mission_time_s=mission_time,
            link=link,
            time_limit_s=time_limit,
            threads=threads,
            record=record,
            record_topics=tuple(record_topic) if record_topic else None,
            report=report,
            autosave=saving,
            show=screen.status,
        )
    print_flight(flown, out, screen)
    if flown.interrupted:
        if connect is None:
            screen.message(f"interrupted; uwsim run --resume --out {out} continues")
        raise typer.Exit(INTERRUPTED)
    if flown.ended_because.startswith(("stuck", "capsized")):
        raise typer.Exit(STUCK)
    if flown.ended_early:
        raise typer.Exit(INCOMPLETE)


def _refuse(options: dict[str, Any], by: str, why: str) -> None:
    """Raise WithoutEffectError for an option that was given although another one leaves it without effect."""
    if given := [name for name, value in options.items() if value is not None]:
        raise WithoutEffectError(f"{given[0]}: cannot be given with {by}: {why}")


def _arguments(texts: list[str]) -> dict[str, Any]:
    import ast

    from uwsim.flight.mission_file import parsed_arguments

    return parsed_arguments(texts, ast.literal_eval)
