"""`uwsim course`: a team's folder, its score over many seeds, and the table of several teams."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.campaigns.workers.options import RetriedOptions
from uwsim.cli.exit_codes import FAILED, INCOMPLETE, INTERRUPTED
from uwsim.cli.groups import show_help
from uwsim.cli.options import SETTINGS, AsJson, print_json, seeds_in
from uwsim.cli.values import exercises, readable, within, writable

if TYPE_CHECKING:
    from uwsim.league.score import Scored

app = typer.Typer(
    name="uwsim course",
    help="A team's workspace, its score, the table of a league.",
    invoke_without_command=True,
    callback=show_help,
    rich_help_panel="Fly",
    **SETTINGS,
)
Folder = Annotated[Path, typer.Argument(help="The team's folder.")]
CourseOption = Annotated[
    str | None,
    typer.Option(help="The course: a packaged exercise, or a file. Default: the team's.", autocompletion=exercises),
]


@app.command()
def new(
    folder: Folder,
    course: Annotated[
        str, typer.Option(help="pool-course, sea-course or reef-course.", autocompletion=exercises)
    ] = "pool-course",
) -> None:
    """Write a team's folder: a pilot that flies a course.

    It is a ROS 2 workspace with one node, a launch file and tests, and has a workflow that flies the course on every
    push without ROS. An existing folder that is not empty is refused.
    """
    from uwsim.league.new import new_team

    for path in new_team(folder, course):
        typer.echo(path)


@app.command()
def world(
    course: Annotated[
        str, typer.Argument(help="A packaged exercise, or a file.", autocompletion=exercises, metavar="COURSE")
    ],
    out: Annotated[Path, typer.Argument(help="The file to write, .yaml.", callback=writable)],
    seed: Annotated[int, typer.Option(help="Places the props.", callback=within(0, 2**32 - 1))] = 0,
) -> None:
    """Write the world of a course and a seed as a scenario.

    `uwsim serve` then starts it for ROS 2, rosbridge and Foxglove, to practise in: nothing is judged.
    """
    from uwsim.exercises import load_exercise
    from uwsim.scenario.dump import write_scenario

    write_scenario(out, load_exercise(course).model_copy(update={"seed": seed}).made_scenario())
    typer.echo(out)


@app.command()
def bag(
    folder: Folder,
    out: Annotated[Path, typer.Argument(help="The file to write, .mcap.", callback=writable)] = Path("first.mcap"),
    course: CourseOption = None,
    seed: Annotated[int, typer.Option(help="Places the props.", callback=within(0, 2**32 - 1))] = 1,
    until: Annotated[float, typer.Option(help="Simulated time to end at [s].", callback=within(1, 1e5, "s"))] = 60.0,
) -> None:
    """Fly the beginning of a run; write a bag for Foxglove.

    It has the pose, the frames, the vehicle's shape, scans and small pictures.
    """
    from uwsim.league.bag import record_bag

    missing = record_bag(folder, seed, out, course=course, until_s=until)
    typer.echo(f"{out}{f'  {missing}' if missing else ''}")


@app.command()
def score(
    *,
    folder: Folder,
    seeds: Annotated[
        Path,
        typer.Option(help="File of seeds: lines of numbers and ranges, such as 1,2,5-20.", callback=readable),
    ],
    course: CourseOption = None,
    user: Annotated[
        str | None,
        typer.Option(help="Run the program as this user of the machine, which takes root. Default: the same user."),
    ] = None,
    sign: Annotated[
        Path | None, typer.Option(help="Sign the result with this key, Ed25519 as PEM.", callback=readable)
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for result.json, sheets, and recordings.")] = Path("results"),
    work: RetriedOptions,
    as_json: AsJson = False,
) -> None:
    """Fly a team's program over a course, once for each seed.

    The program is a process that sees the vehicle's topics and nothing else, and simulated time waits for it: a slow
    machine scores the same. Writes result.json with its digest, a sheet for each seed, and recordings of the best and
    of the worst run. Exits with 4 if the mean is too low to pass.
    """
    from uwsim.campaigns.workers.job_progress import job_progress
    from uwsim.league.score import score_team

    with job_progress("runs") as progress:
        found = score_team(
            folder, seeds_in(seeds), out, course=course, user=user, key=sign, **work.arguments, **progress.arguments,
        )  # fmt: skip
    if not found.result:
        _exit_without(found)
    print_json(found.result) if as_json else _print(found)
    if found.result["mean"] < found.result["pass_points"]:
        raise typer.Exit(INCOMPLETE)


@app.command()
def table(
    results: Annotated[Path, typer.Argument(help="A folder with the results of several teams.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for table.html and table.md. Default: that of the results.")
    ] = None,
    signed_by: Annotated[
        Path | None,
        typer.Option(help="The public key that must have signed each result, as PEM.", callback=readable),
    ] = None,
) -> None:
    """Write the table of several teams' results on one course.

    Each result is checked against its digest, and its signature if it has one. Differences between teams are paired by
    seed.
    """
    from uwsim.flight.folder import made_folder
    from uwsim.league.table import PAGE, TEXT, read_results, table_rows, write_league

    found = read_results(results, signed_by)
    written = write_league(made_folder(results if out is None else out, (PAGE, TEXT)), found)
    for row in table_rows(found):
        typer.echo(f"{row[0]:>3}  {row[2]:>6} ({row[3]})  {row[1]}{f'  behind: {row[4]}' if row[4] else ''}")
    typer.echo("  ".join(map(str, written)))


def _exit_without(found: Scored) -> None:
    if found.failed:
        typer.echo(f"{len(found.failed)} of {found.count} runs failed: {found.failed[0]}", err=True)
        raise typer.Exit(FAILED)
    typer.echo(f"interrupted after {found.finished} of {found.count} runs; --resume continues", err=True)
    raise typer.Exit(INTERRUPTED)


def _print(found: Scored) -> None:
    result = found.result
    for run in result["runs"]:
        missing = "; ".join(run["why"])
        typer.echo(f"seed {run['seed']:6}  {run['score']:6.1f}  {run['time_s']:6.1f} s  {missing}")
    typer.echo(
        f"{result['team']}: {result['mean']:.1f} of {result['points']:g} on average over {len(result['runs'])} seeds, "
        f"95 % interval {result['low']:.1f} to {result['high']:.1f}; {result['passed']} passed"
    )
    typer.echo(found.out / "result.json")
