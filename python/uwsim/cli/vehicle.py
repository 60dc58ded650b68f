"""`uwsim vehicle`: a report on a vehicle's file, in the terminal and as an HTML page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.exit_codes import FAILED
from uwsim.cli.values import vehicles


def vehicle(
    file: Annotated[
        str, typer.Argument(help="A vehicle's YAML file, or the name of a packaged one.", autocompletion=vehicles)
    ],
    out: Annotated[Path | None, typer.Option(help="The HTML page to write. Default: no page.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Report how a vehicle floats, moves and sees.

    Covers mass, buoyancy, trim and righting; added mass and drag beside estimates from the hull's shape (Lamb's
    ellipsoid, Hoerner, panels); terminal speeds and turning circles; eigenvalues of its linear motion; the rank and
    authority of its thrusters; and how much of its own hull each instrument sees. All values are for deep, still, fresh
    water. Exits with 1 if the file has a mistake.
    """
    from uwsim.evidence.scenario_check import check_part
    from uwsim.evidence.vehicle.report import vehicle_report
    from uwsim.evidence.vehicle.text import report_lines

    check = check_part(file, "vehicle")
    for mistake in check.mistakes:
        typer.echo(f"uwsim: error: {mistake}", err=True)
    if check.simulator is None or check.vehicle is None:
        raise typer.Exit(FAILED)
    report = vehicle_report(check.simulator, check.vehicle)
    if as_json:
        typer.echo(json.dumps({**report.to_dict(), "warnings": list(check.warnings)}, indent=1))
    else:
        typer.echo("\n".join([f"{check.file}: {report.model.name}", *report_lines(report)]))
    for warning in check.warnings:
        typer.echo(f"uwsim: warning: {warning}", err=True)
    if out is not None:
        from uwsim.evidence.vehicle.page import write_page

        write_page(out, report, check.warnings)
        typer.echo(f"page: {out}", err=as_json)
