"""`uwsim sweep`: fly a survey or a mission many times with different values."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.base.options import refuse
from uwsim.campaigns.workers.options import RetriedOptions
from uwsim.cli.exit_codes import FAILED, INTERRUPTED
from uwsim.cli.groups import under
from uwsim.cli.values import readable, within

if TYPE_CHECKING:
    from uwsim.campaigns.sweeps import Sweep, SweepPlan

ALONE = "cannot be given with {}, which flies in this process"


@under("Fly")
def sweep(
    *,
    source: Annotated[
        Path, typer.Argument(help="The sweep: what to fly, and what to vary.", metavar="SWEEP.yaml", callback=readable)
    ],
    out: Annotated[Path, typer.Option(help="Folder for runs.parquet, report.html and the worst runs.")] = Path("runs"),
    work: RetriedOptions,
    again: Annotated[
        int | None,
        typer.Option(
            help="Fly only this run again, with recording, map and full report in --out.",
            metavar="RUN",
            callback=within(0, 1e9),
        ),
    ] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write only the table.")] = False,
    plan: Annotated[
        bool,
        typer.Option("--plan", help="Fly three of the runs, print the cost of all and their metrics, write nothing."),
    ] = False,
) -> None:
    """Fly a survey or a mission many times with varying values.

    Varies parameters, faults, missions or seeds. Writes a table of all runs, a report of the important factors, and
    recordings of the worst runs. If it is interrupted or killed, only the runs in progress are lost; --resume
    continues. A run that fails becomes a row with its error. Exits with 1 if a run failed, has no value of the
    sweep's objective because it ended early, or violates the sweep's requirements.
    """
    from uwsim.campaigns.sweeps import fly_again, plan_sweep, run_sweep
    from uwsim.campaigns.workers.job_progress import job_progress
    from uwsim.flight.terminal import Terminal

    screen = Terminal()
    if plan:
        refuse(ALONE.format("--plan"), **work.arguments | {"workers": None}, again=again, no_report=no_report)
        with screen.status("flying three of the runs"):
            found = plan_sweep(source)
        _print_plan(found, work.workers)
        if found.failed:
            raise typer.Exit(FAILED)
        return
    if again is not None:
        refuse(ALONE.format("--again"), **work.arguments, no_report=no_report)
        with screen.status(f"flying run {again} again"):
            differences = fly_again(source, again, out)
        for difference in differences:
            screen.message(difference)
        typer.echo(f"{out}")
        if differences:
            raise typer.Exit(FAILED)
        return
    with job_progress("runs") as progress:
        flown = run_sweep(source, out, report=not no_report, **work.arguments, **progress.arguments)
    _print(flown)
    if flown.interrupted:
        screen.message(f"interrupted after {len(flown.rows):,} of {len(flown.runs):,} runs; --resume continues")
        raise typer.Exit(INTERRUPTED)
    if flown.failed or flown.without_objective or any(flown.missed.values()):
        raise typer.Exit(FAILED)


def _print_plan(plan: SweepPlan, workers: int | None) -> None:
    from uwsim.flight.summary import duration_text

    count = workers or len(os.sched_getaffinity(0))
    low, high = min(plan.processor_s), max(plan.processor_s)
    for name, value in (
        ("runs", f"{plan.runs:,}"),
        ("a run", f"{low:.3g} to {high:.3g} s of processor time (runs {', '.join(map(str, plan.tried))})"),
        ("all runs", f"{duration_text(plan.total_s)} of processor time"),
        (f"on {count} worker{'s' * (count > 1)}", duration_text(plan.total_s / count)),
        ("memory of a worker", f"{plan.memory_bytes / 1e6:.0f} MB"),
        ("ledger", f"{plan.runs * plan.row_bytes / 1e6:.3g} MB"),
    ):
        typer.echo(f"{name:<20}{value}")
    for number, error in plan.failed.items():
        typer.echo(f"run {number}: {error}", err=True)
    typer.echo(f"metrics: {', '.join(plan.metrics)}")


def _print(flown: Sweep) -> None:
    from uwsim.campaigns.sweeps.sweep import REPORT
    from uwsim.campaigns.sweeps.table import TABLE

    counts = f"{flown.failed:,} failed, {flown.ended_early:,} ended early"
    typer.echo(f"{len(flown.rows):,} of {len(flown.runs):,} runs, {counts}")
    for row in flown.rows.failed[:3]:
        typer.echo(f"run {row['run']}: {row['error']}", err=True)
    for row in flown.rows.ended_early[:3]:
        typer.echo(f"run {row['run']} ended early: {row['ended_because']}", err=True)
    if flown.without_objective and flown.spec.objective is not None:
        typer.echo(f"{flown.without_objective:,} runs have no {flown.spec.objective.metric}, the objective", err=True)
    for metric, count in flown.missed.items():
        if count:
            typer.echo(f"{count:,} runs are outside what is required of {metric}", err=True)
    made = [flown.out / name for name in (TABLE, REPORT) if (flown.out / name).exists()]
    typer.echo("  ".join(map(str, made)))
