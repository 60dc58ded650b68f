"""`uwsim ardusub check`: two firmwares or parameter files through the same flight, or a log beside the model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.base.options import need
from uwsim.cli.bounds import readable, within
from uwsim.cli.seeds import parsed_seeds
from uwsim.cli.values import scenarios, vehicle_models

if TYPE_CHECKING:
    from uwsim.bridges.firmware.report import Row

SEEDS, WINDOW_S = "4", 5.0
REPORT, FLIGHTS, DEPTHS_PICTURE, LOG_PICTURE = "report.md", "flights.csv", "depths.png", "log.png"


def ardusub_check(
    *,
    first: Annotated[
        Path,
        typer.Argument(help="A compiled ArduSub, a parameter file, or a log (.bin).", callback=readable),
    ],
    second: Annotated[
        Path | None,
        typer.Argument(help="Another ArduSub or parameter file; none beside a log.", callback=readable),
    ] = None,
    binary: Annotated[
        Path | None, typer.Option(help="The compiled ArduSub that reads two parameter files.", callback=readable)
    ] = None,
    scenario: Annotated[
        str, typer.Option(help="Name of a packaged scenario, or path of a YAML file.", autocompletion=scenarios)
    ] = "lagoon",
    vehicle: Annotated[
        str, typer.Option(help="Vehicle: a packaged name or a YAML file.", autocompletion=vehicle_models)
    ] = "bluerov2_heavy_outfit",
    seeds: Annotated[
        str | None,
        typer.Option(help="How many seeds from 0, such as 4; or a list, such as 3,7,100-129. Default: 4."),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(help="Flights at the same time. Default: one per core.", callback=within(1, 1024)),
    ] = None,
    window: Annotated[
        float | None,
        typer.Option(
            help="With a log: the model starts from the log's motion again after this time [s]. Default: 5.",
            callback=within(0.2, 1e4, "s"),
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for report.md, flights.csv and the picture.")] = Path("check"),
) -> None:
    """Compare two ArduSubs or parameter files in the same sea.

    Or a log with the model.

    Each flies the same flight, with the sensors' errors of each seed: ALT_HOLD, STABILIZE ahead, POSHOLD. A log's servo
    outputs drive the model, whose motion is compared with the log's.
    """
    if second is None:
        need("two programs or parameter files", binary=binary, seeds=seeds, workers=workers)
        rows, page = _beside_the_model(first, scenario, vehicle, window or WINDOW_S, out)
    else:
        need("a log", window=window)
        rows, page = _side_by_side(
            (first, second), binary, scenario, vehicle, parsed_seeds(seeds or SEEDS, "--seeds"), workers, out
        )
    from uwsim.bridges.firmware.report import text_of

    typer.echo(text_of(rows))
    typer.echo(str(page))


def _beside_the_model(log: Path, scenario: str, vehicle: str, window_s: float, out: Path) -> tuple[list[Row], Path]:
    """Return the table and the path of the report."""
    from uwsim.bridges.ardusub.ardusub import prepared
    from uwsim.bridges.firmware.dataflash_log import compared, read_servo_log
    from uwsim.bridges.firmware.report import draw_log, log_rows, write_report
    from uwsim.flight.folder import made_folder
    from uwsim.scenario import load

    flight, world = read_servo_log(log), prepared(load(scenario), vehicle)
    made_folder(out, (REPORT, LOG_PICTURE))
    found = compared(flight, world, window_s)
    rows = log_rows(found)
    draw_log(out / LOG_PICTURE, found)
    about = f"{vehicle} in still water of {scenario}, from the log's motion again every {window_s:g} s."
    return rows, write_report(out, f"{log.name} and the model", about, rows, LOG_PICTURE)


def _side_by_side(
    paths: tuple[Path, Path],
    binary: Path | None,
    scenario: str,
    vehicle: str,
    seeds: list[int],
    workers: int | None,
    out: Path,
) -> tuple[list[Row], Path]:
    """Return the table and the path of the report; each flight is in flights.csv as soon as it has ended."""
    import os

    from uwsim.bridges.firmware.check import checked, sides_of
    from uwsim.bridges.firmware.report import draw_depths, side_rows, write_flights, write_report
    from uwsim.flight.folder import made_folder

    sides = sides_of(*paths, binary)
    names = [side.name for side in sides]
    made_folder(out, (REPORT, FLIGHTS, DEPTHS_PICTURE))
    flights = []
    for each in checked(sides, scenario, vehicle, seeds, workers or os.cpu_count() or 1):
        flights.append(each)
        flights.sort(key=lambda one: (names.index(one.side), one.seed))
        write_flights(out / FLIGHTS, flights)
        typer.echo(f"{each.side}, seed {each.seed}: {len(flights)} of {2 * len(seeds)}", err=True)
    rows = side_rows(flights, names)
    draw_depths(out / DEPTHS_PICTURE, flights, names)
    about = f"{vehicle} in {scenario}, {len(seeds)} seeds: mean ± standard deviation; difference ± standard error."
    return rows, write_report(out, " and ".join(names), about, rows, DEPTHS_PICTURE)
