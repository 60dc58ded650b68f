"""`uwsim validate`: compare the simulator with closed forms and published data."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.stoppable import ending_signals
from uwsim.cli.exit_codes import FAILED
from uwsim.cli.groups import under
from uwsim.cli.options import AsJson, print_json
from uwsim.cli.values import UsageError, one_of, within
from uwsim.evidence.suites import ON_REQUEST, SUITES

BY_DEFAULT = [name for name in SUITES if name not in ON_REQUEST]
OFFERED = (
    f"Any of {', '.join(BY_DEFAULT)} (default: all of these); flights and reality, which need --data; peers, which "
    "also uses gsw, mujoco, opencv-python-headless, filterpy, pvlib."
)


@under("Check")
def validate(
    suites: Annotated[
        list[str] | None,
        typer.Argument(help=OFFERED, **one_of(*SUITES)),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for index.md, the tables, and the curves as PNG.")] = None,
    data: Annotated[
        Path | None,
        typer.Option(
            help="Folder of recorded data for reality, whose sources docs/inside/reality.md lists, or of logs for "
            "flights, with flights.yaml.",
            exists=True,
            file_okay=False,
        ),
    ] = None,
    engine: Annotated[
        str,
        typer.Option(
            help="Engine for the dynamics suite: uwsim (default), or bullet, Bullet's own dynamics.",
            **one_of("uwsim", "bullet"),
        ),
    ] = "uwsim",
    jobs: Annotated[
        int | None,
        typer.Option(
            help="Number of suites to run at once, each in a process. Default: one per core.", callback=within(1, 64)
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compare the simulator with closed forms and published data.

    Prints expected value, computed value and error; exits with 1 if a check fails. After reality, it also prints the
    predictions that were frozen before their data were opened, and which hit; a miss does not change the exit code.
    """
    from uwsim.evidence.validate import run_suites
    from uwsim.evidence.validate.report import print_checks, write_page

    names = suites or BY_DEFAULT
    if engine != "uwsim" and names != ["dynamics"]:
        raise UsageError(f"--engine = {engine}: only the suite dynamics can be run with it (uwsim validate dynamics)")
    jobs = min(jobs or len(os.sched_getaffinity(0)), len(names))
    if jobs > 1:
        for number in ending_signals():
            signal.signal(number, signal.default_int_handler)  # raises an exception, which ends the jobs' processes
    found = {}
    for suite, checks in run_suites(names, out, jobs, data, engine):
        found[suite] = checks
        if as_json:
            continue
        print_checks(checks, suite)
        if suite == "reality":
            from uwsim.evidence.validate.reality.predictions import print_predictions

            print_predictions()
    if as_json:
        print_json({suite: [check.to_dict() for check in checks] for suite, checks in found.items()})
    if out is not None:
        write_page(out, found)
    if not all(check.passed for checks in found.values() for check in checks):
        raise typer.Exit(FAILED)
