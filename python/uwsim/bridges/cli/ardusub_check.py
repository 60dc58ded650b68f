"""`uwsim ardusub-check`: two firmwares or parameter files through the same flight, or a log beside the model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.bounds import readable, within
from uwsim.cli.groups import under
from uwsim.cli.values import scenarios, vehicle_models


@under("Check")
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
    seeds: Annotated[int, typer.Option(help="Number of flights of each.", callback=within(1, 10_000))] = 4,
    workers: Annotated[
        int | None,
        typer.Option(help="Flights at the same time. Default: one per core.", callback=within(1, 1024)),
    ] = None,
    window: Annotated[
        float,
        typer.Option(
            help="With a log: the model starts from the log's motion again after this time [s].",
            callback=within(0.2, 1e4, "s"),
        ),
    ] = 5.0,
    out: Annotated[Path, typer.Option(help="Folder for report.md, flights.csv and the picture.")] = Path("check"),
) -> None:
    """Compare two ArduSubs, or two parameter files, in the same sea; or a log with the model.

    Each flies the same flight, with the sensors' errors of each seed: ALT_HOLD, STABILIZE ahead, POSHOLD. A log's servo
    outputs drive the model, whose motion is compared with the log's.
    """
    from uwsim.bridges.firmware_report import draw_depths, draw_log, log_rows, side_rows, text_of, write_flights
    from uwsim.bridges.firmware_report import write_report as written

    if second is None:
        from uwsim.bridges.ardusub import prepared
        from uwsim.bridges.firmware_log import compared, read_servo_log
        from uwsim.scenario import load

        found = compared(read_servo_log(first), prepared(load(scenario), vehicle), window)
        out.mkdir(parents=True, exist_ok=True)
        rows = log_rows(found)
        draw_log(out / "log.png", found)
        about = f"{vehicle} in still water of {scenario}, from the log's motion again every {window:g} s."
        page = written(out, f"{first.name} and the model", about, rows, "log.png")
    else:
        import os

        from uwsim.bridges.firmware_check import checked, sides_of

        sides = sides_of(first, second, binary)
        names = [side.name for side in sides]
        out.mkdir(parents=True, exist_ok=True)
        flights = []
        for each in checked(sides, scenario, vehicle, range(seeds), workers or os.cpu_count() or 1):
            flights.append(each)
            typer.echo(f"{each.side}, seed {each.seed}: {len(flights)} of {2 * seeds}", err=True)
        flights.sort(key=lambda each: (names.index(each.side), each.seed))
        rows = side_rows(flights, names)
        draw_depths(out / "depths.png", flights, names)
        write_flights(out / "flights.csv", flights)
        about = f"{vehicle} in {scenario}, {seeds} seeds: mean ± standard deviation; difference ± standard error."
        page = written(out, " and ".join(names), about, rows, "depths.png")
    typer.echo(text_of(rows))
    typer.echo(str(page))
