"""`uwsim validate`: compare the simulator with closed forms and published data."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.choices import one_of
from uwsim.cli.exit_codes import FAILED


def validate(
    suites: Annotated[
        list[str] | None,
        typer.Argument(
            help="Any of dynamics, sonar, imaging, camera, link, control, estimation. Default: all.",
            **one_of("dynamics", "sonar", "imaging", "camera", "link", "control", "estimation"),
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for index.md, the tables, and the curves as PNG.")] = None,
) -> None:
    """Compare the simulator with closed forms and published data.

    Prints expected, got and error; exits with 1 on a miss.
    """
    from uwsim.evidence.validate import SUITES, run_suite
    from uwsim.evidence.validate.check_table import print_checks
    from uwsim.evidence.validate.page import write_page

    found = {}
    for suite in suites or SUITES:
        found[suite] = run_suite(suite, out)
        print_checks(found[suite], suite)
    if out is not None:
        write_page(out, found)
    if not all(check.passed for checks in found.values() for check in checks):
        raise typer.Exit(FAILED)
