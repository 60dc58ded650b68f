"""`uwsim compare`: compare several missions over several seeds in one table, by choice as a named benchmark."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from uwsim.base.options import Options, need, option, refuse
from uwsim.base.sockets import PLANNERS, planner, registered
from uwsim.base.stoppable import note_kept
from uwsim.cli.groups import under
from uwsim.cli.options import VOXEL, VOXELS, Threads, parsed_seeds
from uwsim.cli.values import packaged, words

if TYPE_CHECKING:
    from uwsim.flight.compare import Comparison, Row


COVERING = ("unknown_water", "frontier", "boustrophedon")  # those that cover an area
WIDTH = 180  # width of the table if stdout is a file
SURVEY = "survey"  # the mission that flies the scenario's own survey
BY: dict[str, Literal["truth", "filter"]] = {"truth": "truth", "estimate": "filter"}
COLUMNS: dict[str, Callable[[Row], str]] = {
    "mission": lambda row: row.mission,
    "seed": lambda row: f"{row.seed}",
    "time [s]": lambda row: f"{row.time_s:.0f}",
    "path [m]": lambda row: f"{row.path_m:.0f}",
    "effort [s]": lambda row: f"{row.effort_s:.0f}",
    "battery [%]": lambda row: f"{row.battery_percent:.1f}",
    "collisions": lambda row: f"{row.collisions}",
    "lost [m]": lambda row: f"{row.estimate_rms_m:.2f}",
    "seen [m²]": lambda row: f"{row.seen_m2:.0f}",
    "of all [%]": lambda row: f"{100 * row.seen_share:.0f}",
    "half seen [s]": lambda row: f"{row.half_seen_s:.0f}",
    "map coverage [%]": lambda row: f"{100 * row.map_coverage:.0f}",
    "map error [m]": lambda row: f"{row.map_error_m:.3f}",
    "off target [m]": lambda row: f"{row.off_target_m:.2f}",
}


@dataclass(frozen=True)
class Conditions(Options):
    """The conditions of all flights, which a benchmark sets."""

    scenario: str | None = option(None, "Packaged scenario, or a YAML file. Default: cove.", completion="scenarios")
    voxel_m: float | None = option(None, VOXEL, bounds=VOXELS)
    by: str | None = option(
        None, "State for the missions: truth (default), or estimate (by the vehicle's filter).", choices=tuple(BY)
    )
    fault: tuple[str, ...] = option(
        (), "A fault in each flight, such as 'kind: sensor, sensor: dvl, mode: off, at_s: 60'."
    )
    time_limit_s: float | None = option(
        None, "End each flight after this simulated time [s].", bounds=(0.001, 1e9, "s")
    )
    set: tuple[str, ...] = option((), "NAME=VALUE for a parameter of every mission.")


@under("Fly")
def compare(
    *,
    missions: Annotated[
        list[str] | None,
        typer.Argument(
            help=f"Missions: files, or planners: {', '.join(registered(PLANNERS))}. Default: {', '.join(COVERING)}.",
            metavar="[MISSION]...",
            show_default=False,
            autocompletion=words(*registered(PLANNERS)),
        ),
    ] = None,
    benchmark: Annotated[
        str | None,
        typer.Option(
            help="Compare with the baseline of a named benchmark, or of a YAML file, under its conditions.",
            autocompletion=packaged("benchmarks"),
        ),
    ] = None,
    held_out: Annotated[
        bool,
        typer.Option("--held-out", help="Fly the benchmark's held-out seeds, and write submission.json."),
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder for compare.csv, .json and .png, and each flight's folder.")] = Path(
        "compare"
    ),
    seeds: Annotated[
        str | None,
        typer.Option(help="How many seeds from 0, such as 30; or a list, such as 3,7,100-129. Default: 3."),
    ] = None,
    conditions: Conditions,
    resume: Annotated[
        bool, typer.Option("--resume", help="Keep the flights that --out already holds, and fly the rest.")
    ] = False,
    threads: Threads = None,
) -> None:
    """Fly missions over seeds in the same water and compare them.

    Compares area seen and its share, time, path, effort, battery, collisions, and the map's coverage and error. Each
    mission is then compared with the first one, seed by seed: median difference, its 95 % interval, and wins.
    """
    import ast

    from uwsim.flight.benchmark import HELD_OUT, SEEDS, SUBMISSION, load_benchmark, write_submission
    from uwsim.flight.compare import compare as fly_all
    from uwsim.flight.folder import made_folder
    from uwsim.flight.mission_file import parsed_arguments
    from uwsim.flight.paired import MORE_IS_BETTER
    from uwsim.flight.terminal import Terminal

    task = load_benchmark(benchmark) if benchmark is not None else None
    if task is not None:
        refuse(f"is set by the benchmark {task.name}; leave it out", **conditions.arguments)
    else:
        need("--benchmark", held_out=held_out)
    chosen = _missions([task.baseline, *(missions or ())] if task else missions or COVERING)
    numbers = parsed_seeds(seeds, "--seeds") if seeds is not None else [0, 1, 2]
    if task is not None and seeds is None:
        numbers = list(HELD_OUT if held_out else SEEDS)
    elif task is not None and (set(numbers) & set(HELD_OUT) if not held_out else set(numbers) - set(HELD_OUT)):
        rule = f"held-out seeds are {HELD_OUT[0]} to {HELD_OUT[-1]}, and only with --held-out"
        raise ValueError(f"--seeds {seeds}: {rule}")
    if held_out:
        made_folder(out, (SUBMISSION,))  # before hours of flights
    screen = Terminal()
    if task is not None:
        screen.message(f"{task.name}: {task.task}")
    of_task = task if task is not None else conditions
    found = fly_all(
        chosen, task.scenario_of if task else conditions.scenario or "cove", out, seeds=numbers,
        arguments=parsed_arguments(list(conditions.set), ast.literal_eval),
        estimate=task.estimate if task else BY[conditions.by or "truth"],
        faults=[_fault(text) for text in conditions.fault],
        time_limit_s=of_task.time_limit_s, voxel_m=of_task.voxel_m, target=task.target if task else None,
        threads=threads, resume=resume, show=screen.status, show_row=_print_row,
    )  # fmt: skip
    _print(found, task.values if task else MORE_IS_BETTER)
    typer.echo(f"{out / 'compare.png'}")
    if task is not None and held_out:
        files = {name: flown if isinstance(flown, Path) else None for name, flown in chosen.items()}
        typer.echo(f"{write_submission(task, found, files, out)}")


def _missions(names: Iterable[str]) -> dict[str, Any]:
    planners = registered(PLANNERS)
    chosen: dict[str, Any] = {}
    for text in names:
        name = Path(text).stem
        if text not in (*planners, SURVEY) and not Path(text).is_file():
            raise ValueError(f"mission '{text}': must be a file, or one of {', '.join(planners)}, {SURVEY}")
        if name in chosen:
            raise ValueError(f"mission '{text}': there is another '{name}'")
        chosen[name] = None if text == SURVEY else planner(text) if text in planners else Path(text)
    return chosen


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


def _print_row(row: Row) -> None:
    note_kept("finished flights are kept: --resume flies the rest")
    ended = "" if row.ended_because == "the mission is complete" else f"; {row.ended_because}"
    typer.echo(
        f"{row.mission}, seed {row.seed}: {row.time_s:.0f} s, {row.seen_m2:.0f} m² seen, map coverage "
        f"{100 * row.map_coverage:.0f} %, error {row.map_error_m:.3f} m, {row.collisions} collisions{ended}"
    )


def _print(found: Comparison, values: Iterable[str]) -> None:
    from rich.console import Console
    from rich.table import Table

    from uwsim.flight.paired import LEAST_FOR_INTERVAL, without_randomness

    has_target = any(row.off_target_m == row.off_target_m for row in found.rows)
    columns = {title: shown for title, shown in COLUMNS.items() if has_target or title != "off target [m]"}
    table = Table(*columns)
    for row in found.rows:
        table.add_row(*(shown(row) for shown in columns.values()))
    pairs = Table("mission", "against", "value", "seeds", "median difference", "95 % interval of it", "wins", "losses")
    for pair in (pair for pair in found.pairs if pair.value in values):
        interval = (
            f"{pair.low:+.3g} to {pair.high:+.3g}" if pair.low == pair.low else f"from {LEAST_FOR_INTERVAL} seeds"
        )
        pairs.add_row(
            pair.mission, pair.against, pair.value, f"{pair.seeds}", f"{pair.median:+.3g}", interval,
            f"{pair.wins} of {pair.seeds}", f"{pair.losses}",
        )  # fmt: skip
    for each in (table, pairs):
        for column in each.columns[1:]:
            column.justify = "right"
    console = Console()
    for each in (table, pairs) if found.pairs else (table,):
        (console if console.is_terminal else Console(width=WIDTH)).print(each)
    for name in without_randomness(found.rows):
        typer.echo(f"{name}: every seed gave the same flight: nothing in this scenario is random for it; one is enough")
