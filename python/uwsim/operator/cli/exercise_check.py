"""`uwsim exercise check`: whether a score sheet is as it was written."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.bounds import readable
from uwsim.cli.options import AsJson, print_json


def check(
    sheet: Annotated[Path, typer.Argument(help="The sheet, score.json.", callback=readable)], as_json: AsJson = False
) -> None:
    """Check that a score sheet is as it was written, by its digest."""
    from uwsim.exercises.certified import read_sheet

    found = read_sheet(sheet)
    if as_json:
        print_json(found)
    else:
        by = found["person"] or "not named"
        typer.echo(f"{sheet}: is as it was written: {by}, {found['title']}, {found['date']}")
