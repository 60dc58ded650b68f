"""`uwsim ros doctor`: find out why ROS and the simulator do not see each other."""

from __future__ import annotations

from typing import Annotated

import typer

from uwsim.bridges.requested import ExaminedBridges
from uwsim.cli.values import within

MARKS = {"ok": "ok", "note": "-", "wrong": "WRONG"}


def doctor(
    bridges: ExaminedBridges,
    listen: Annotated[
        float, typer.Option(help="How long to listen for ROS 2 nodes [s].", callback=within(0.1, 60, "s"))
    ] = 3.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON list of findings.")] = False,
) -> int:
    """Diagnose the installation, and why ROS does not connect.

    Checks processor, extras and versions, and which nodes answer. Exits with 1 if something is wrong.
    """
    import json
    from dataclasses import asdict

    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from uwsim.bridges.doctor.software import software

    console = Console(stderr=as_json)
    with console.status(f"looking and listening for {listen:g} s"):
        findings = [*software(), *bridges.examine(listen)]
    wrong = sum(finding.verdict == "wrong" for finding in findings)
    if as_json:
        typer.echo(json.dumps([asdict(finding) for finding in findings], indent=1))
        return 1 if wrong else 0
    table = Table("", "", "found", "what to do", show_edge=False)
    for column in table.columns:
        column.overflow = "fold"  # a command that is cut could not be run
    for finding in findings:
        table.add_row(MARKS[finding.verdict], *map(escape, (finding.what, finding.found, finding.advice)))
    (console if console.is_terminal else Console(width=1000)).print(table)  # in a pipe, a row is one line
    console.print("nothing is wrong" if not wrong else f"{wrong} wrong")
    return 1 if wrong else 0
