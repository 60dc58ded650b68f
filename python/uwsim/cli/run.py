"""`uwsim run`: fly a mission from a file."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.base.options import WithoutEffectError, flag_name, need, refuse
from uwsim.cli.autopilots import Autopilots, prepared
from uwsim.cli.flights import FlightOptions, MapOptions, Out, exit_as, given
from uwsim.cli.groups import under
from uwsim.cli.options import SimulatorOptions
from uwsim.cli.values import readable, scenarios
from uwsim.flight.attachment import Attachments, Elsewhere

if TYPE_CHECKING:
    from uwsim.flight.record import FlightRecord
    from uwsim.simulator.simulator import Simulator


@under("Fly")
def run(
    *,
    mission: Annotated[
        Path | None,
        typer.Argument(
            help="A Python file with `def mission(vehicle): yield ...`, or a file of the field: a QGroundControl plan, "
            "QGC WPL 110 (.waypoints), GeoJSON or KML.",
            show_default=False,
            callback=readable,
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
    vehicle: Annotated[
        list[str] | None,
        typer.Option(help="Vehicle that flies; may be given several times. Default: the first, or all for `vehicles`."),
    ] = None,
    argument: Annotated[
        list[str] | None, typer.Option("--set", help="NAME=VALUE for another parameter of the mission.")
    ] = None,
    function: Annotated[str | None, typer.Option(help="Name of the mission's function. Default: mission.")] = None,
    make_map: Annotated[bool, typer.Option("--map", help="Build an OctoMap from the sonar's pings.")] = False,
    simulator: SimulatorOptions,
    maps: MapOptions,
    flight: FlightOptions,
    attachments: Attachments,
    autopilots: Autopilots,
    elsewhere: Elsewhere,
) -> None:
    """Fly a mission from a file; write its log, map and report.

    Ctrl-C ends it early and keeps the results so far. If it is killed, the log and the last saved map remain.
    """
    autopilot, other = autopilots.only, elsewhere.only
    of_map = maps.given() | {name: True for name in attachments.requested if name == "raw"}
    if mission is None:
        raise WithoutEffectError("needs the mission's file, such as my_mission.py")
    if other is not None:
        beside = f"cannot be given with {flag_name(str(other.switch))}"
        simulated = simulator.given() | of_map | dict.fromkeys(attachments.arguments, True)
        simulated |= {"estimate": flight.estimate is not None, **dict.fromkeys(autopilots.requested, True)}
        refuse(f"{beside}: the map is written at the end", autosave_s=flight.autosave_s is not None)
        refuse(f"{beside}: the server has its own, or there is none", **{**simulated, "voxel_m": False})
    if not make_map:
        need("--map", **of_map)
    flight.require_fit(maps)
    from uwsim.flight.terminal import Terminal

    asked = given(
        function=function, arguments=_arguments(argument or []) or None, vehicles=tuple(vehicle or ()) or None,
        map=make_map or None, screen=Terminal(),
    )  # fmt: skip
    asked |= flight.arguments | maps.arguments
    flown: FlightRecord
    if other is not None:
        flown = other.fly(mission, out, truth=scenario, **asked)
    else:
        from uwsim.flight.fly import fly

        scene: str | Path | Simulator = scenario or "lake"
        of_simulator = simulator.arguments
        with ExitStack() as stack:
            if autopilot is not None:
                scene, of_simulator = prepared(autopilot, scenario or "lake", **of_simulator), {}
                typer.echo(stack.enter_context(autopilot.flying(scene)))
            asked |= of_simulator | attachments.arguments
            flown = fly(mission, scene, out, **asked)
    exit_as(flown, maps.min_coverage)


def _arguments(texts: list[str]) -> dict[str, Any]:
    import ast

    from uwsim.flight.mission_file import parsed_arguments

    return parsed_arguments(texts, ast.literal_eval)
