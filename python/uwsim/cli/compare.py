"""`uwsim compare`: compare several missions over several seeds in one table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from uwsim.cli.bounds import within
from uwsim.cli.choices import one_of
from uwsim.cli.options import Threads
from uwsim.cli.values import scenarios

if TYPE_CHECKING:
    from uwsim.flight.compare import Comparison


WIDTH = 165  # width of the table if stdout is a file
BY: dict[str, Literal["truth", "filter"]] = {"truth": "truth", "estimate": "filter"}


def compare(
    missions: Annotated[
        list[str] | None,
        typer.Argument(
            help="Missions: files, or planners: unknown_water, frontier, boustrophedon (default: these three), "
            "pipeline, gate, wall, curves.",
            metavar="[MISSION]...",
            show_default=False,
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
    from uwsim.missions.planners.area_missions import AREA_MISSIONS
    from uwsim.missions.planners.inspection_missions import INSPECTION_MISSIONS

    known = {**AREA_MISSIONS, **INSPECTION_MISSIONS}
    chosen: dict[str, Any] = {}
    for text in missions or AREA_MISSIONS:
        name = Path(text).stem
        if text not in known and not Path(text).is_file():
            raise ValueError(f"mission '{text}': must be a file, or one of {', '.join(known)}")
        if name in chosen:
            raise ValueError(f"mission '{text}': there is another '{name}'")
        chosen[name] = known.get(text) or Path(text)
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
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        fault = YAML(typ="safe").load(text if text.lstrip().startswith("{") else f"{{{text}}}")
    except YAMLError:
        fault = None
    if not isinstance(fault, dict) or "kind" not in fault:
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
