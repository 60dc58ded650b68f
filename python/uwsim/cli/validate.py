"""`uwsim validate`: compare the simulator with closed forms and published data."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.exit_codes import FAILED


def validate(
    suites: Annotated[
        list[str] | None,
        typer.Argument(help="Any of dynamics, sonar, imaging, camera, link, control, estimation. Default: all."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the curves as PNG.")] = None,
) -> None:
    """Compare the simulator with closed forms and published data.

    Prints expected, got and error; exits with 1 on a miss.
    """
    from uwsim.validate import SUITES, run_suite
    from uwsim.validate.check_table import print_checks

    missed = False
    for suite in suites or SUITES:
        checks = run_suite(suite, out)
        print_checks(checks, suite)
        missed = missed or not all(check.passed for check in checks)
    if missed:
        raise typer.Exit(FAILED)
