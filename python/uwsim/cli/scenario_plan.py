"""`uwsim scenario plan`: write a survey or a mission as a plan for QGroundControl."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.values import scenarios, writable


def plan(
    source: Annotated[
        str,
        typer.Argument(
            help="Name of a packaged scenario, path of a YAML file, or a file of the field.", autocompletion=scenarios
        ),
    ],
    out: Annotated[Path, typer.Option(help="The file to write.", callback=writable)] = Path("survey.plan"),
) -> None:
    """Write a survey as a QGroundControl plan.

    The lanes of a scenario's survey become waypoints above the bed; the items of a file of the field are kept.
    """
    from uwsim.base.atomic_file import write_atomically
    from uwsim.flight.plan_export import plan_of

    document, note = plan_of(source)
    write_atomically(out, (json.dumps(document, indent=4) + "\n").encode())
    if note is not None:
        typer.echo(f"uwsim: warning: {note}", err=True)
    typer.echo(str(out))
