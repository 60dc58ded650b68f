"""`uwsim compare`: compare several missions over several seeds in one table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from uwsim.base.sockets import load, registered
from uwsim.cli.bounds import within
from uwsim.cli.choices import one_of
from uwsim.cli.groups import under
from uwsim.cli.options import Threads
from uwsim.cli.values import scenarios, words

if TYPE_CHECKING:
    from uwsim.flight.compare import Comparison


PLANNERS = "uwsim.kinds.planner"  # entry points: missions, functions of a vehicle and of arguments with defaults
COVERING = ("unknown_water", "frontier", "boustrophedon")  # those that cover an area
WIDTH = 165  # width of the table if stdout is a file
BY: dict[str, Literal["truth", "filter"]] = {"truth": "truth", "estimate": "filter"}


@under("Fly")
def compare(
    missions: Annotated[
        list[str] | None,
        typer.Argument(
            help=f"Missions: files, or planners: {', '.join(registered(PLANNERS))}. Default: {', '.join(COVERING)}.",
            metavar="[MISSION]...",
            show_default=False,
            autocompletion=words(*registered(PLANNERS)),
        ),
    ] = None,
    scenario: Annotated[
        str, typer.Option(help="Name of a packaged scenario, or path of a YAML file.", autocompletion=scenarios)
    ] = "cove",
    out: Annotated[Path, typer.Option(help="Folder for compare.csv, .json and .png, and each flight's folder.")] = Path(
        "compare"
    ),
    seeds: Annotated[str, typer.Option(help="Seeds, such as 0,1,2.")] = "0,1,2",
    voxel: Annotated[
        float | None,
        typer.Option(help="Edge of the maps' voxels [m]; replaces the scenario's.", callback=within(0.02, 10, "m")),
    ] = None,
    by: Annotated[
        str,
        typer.Option(help="State for the missions: truth, or estimate (by the vehicle's filter).", **one_of(*BY)),
    ] = "truth",
    fault: Annotated[
        list[str] | None,
        typer.Option(help="A fault in each flight, such as 'kind: sensor, sensor: dvl, mode: off, at_s: 60'."),
    ] = None,
    time_limit: Annotated[
        float | None,
        typer.Option(help="End each flight after this simulated time [s].", callback=within(0.001, 1e9, "s")),
    ] = None,
    argument: Annotated[
        list[str] | None, typer.Option("--set", help="NAME=VALUE for a parameter of every mission.")
    ] = None,
    threads: Threads = None,
) -> None:
    """Fly missions over seeds in the same water and compare them.

    Compares area seen and its share, time, path, effort, battery, collisions, and the map's coverage and error.
    """
    import ast

    from uwsim.flight.compare import compare as fly_all
    from uwsim.flight.mission_file import parsed_arguments
    from uwsim.flight.terminal import Terminal

    planners = registered(PLANNERS)
    chosen: dict[str, Any] = {}
    for text in missions or COVERING:
        name = Path(text).stem
        if text not in planners and not Path(text).is_file():
            raise ValueError(f"mission '{text}': must be a file, or one of {', '.join(planners)}")
        if name in chosen:
            raise ValueError(f"mission '{text}': there is another '{name}'")
        chosen[name] = load(PLANNERS, text) if text in planners else Path(text)
    try:
        numbers = [int(seed) for seed in seeds.split(",")]
    except ValueError:
        raise ValueError(f"--seeds {seeds}: must be whole numbers, such as 0,1,2") from None
    screen = Terminal()
    found = fly_all(
        chosen, scenario, out, seeds=numbers, arguments=parsed_arguments(argument or [], ast.literal_eval),
        estimate=BY[by], faults=[_fault(text) for text in fault or ()],
        time_limit_s=time_limit, voxel_m=voxel, threads=threads, show=screen.status,
    )  # fmt: skip
    _print(found)
    typer.echo(f"{out / 'compare.png'}")


def _fault(text: str) -> dict[str, Any]:
    """Parse a fault, written as in a scenario file, with or without its braces. Raises ValueError."""
    from uwsim.base.texts.yaml_document import yaml_document

    try:
        fault = yaml_document(text if text.lstrip().startswith("{") else f"{{{text}}}", "--fault").values
    except ValueError:
        fault = {}
    if "kind" not in fault:
        raise ValueError(
            f"--fault {text}: must be written as in a scenario, such as 'kind: sensor, sensor: dvl, at_s: 60'"
        )
    return fault


def _print(found: Comparison) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table()
    columns = (
        "mission", "seed", "time [s]", "path [m]", "effort [s]", "battery [%]", "collisions", "lost [m]", "seen [m²]",
        "of all [%]", "half seen [s]", "map coverage [%]", "map error [m]",
    )  # fmt: skip
    for column in columns:
        table.add_column(column, justify="left" if column == "mission" else "right")
    for row in found.rows:
        table.add_row(
            row.mission, f"{row.seed}", f"{row.time_s:.0f}", f"{row.path_m:.0f}", f"{row.effort_s:.0f}",
            f"{row.battery_percent:.1f}", f"{row.collisions}", f"{row.estimate_rms_m:.2f}",
            f"{row.seen_m2:.0f}", f"{100 * row.seen_share:.0f}",
            f"{row.half_seen_s:.0f}", f"{100 * row.map_coverage:.0f}", f"{row.map_error_m:.3f}",
        )  # fmt: skip
    console = Console()
    (console if console.is_terminal else Console(width=WIDTH)).print(table)
    for row in found.rows:
        if row.ended_because != "the mission is complete":
            typer.echo(f"{row.mission}, seed {row.seed}: {row.ended_because}")
