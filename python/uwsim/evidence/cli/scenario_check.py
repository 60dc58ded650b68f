"""`uwsim scenario check`: find mistakes in files, and describe their contents."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import WithoutEffectError
from uwsim.cli.exit_codes import FAILED
from uwsim.cli.scenario import KINDS
from uwsim.cli.values import one_of, scenarios


def check(
    files: Annotated[
        list[str], typer.Argument(help="YAML files, or names of packaged scenarios.", autocompletion=scenarios)
    ],
    picture: Annotated[Path | None, typer.Option(help="Draw the scene into this PNG.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Write a JSON list of reports.")] = False,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 1 for warnings, too.")] = False,
    kind: Annotated[
        str,
        typer.Option(
            help="Contents of the files: scenario, vehicle, thruster, sonar, sensors, modem or battery.",
            **one_of(*KINDS),
        ),
    ] = "scenario",
) -> None:
    """Check files, and describe their contents.

    All mistakes in a file are listed at once. If there are none, its contents are built, to report their positions, how
    each vehicle floats and steers, and likely oversights. Exits with 0 if there are no mistakes, with 1 if a file has a
    mistake or, with --strict, a warning, and with 2 for a wrong option.
    """
    from uwsim.evidence.scenario_check import check_file, check_part

    if picture is not None and (len(files) > 1 or kind != "scenario"):
        raise WithoutEffectError("--picture: needs one file, of a scenario")
    reports = [check_file(file) if kind == "scenario" else check_part(file, kind) for file in files]
    if as_json:
        typer.echo(json.dumps([report.to_dict() for report in reports], indent=2))
    else:
        _print(reports)
    if picture is not None and (sim := reports[0].simulator) is not None:
        from uwsim.figures.scene import draw_scene

        draw_scene(picture, sim.scenario, sim.world)
        typer.echo(str(picture), err=as_json)
    if any(report.mistakes or (strict and report.warnings) for report in reports):
        raise typer.Exit(FAILED)


def _print(reports: list) -> None:  # type: ignore[type-arg]  # the class is imported where it is used
    from uwsim.evidence.scenario_check.text import report_lines

    for report in reports:
        for mistake in report.mistakes:
            typer.echo(f"uwsim: error: {mistake}", err=True)
        if not report.mistakes:
            typer.echo("\n".join(report_lines(report)))
        for warning in report.warnings:
            typer.echo(f"uwsim: warning: {warning}", err=True)
