"""`uwsim exercise`: fly an exercise with a script as its pilot, or serve it at the operator's station."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.base.options import OptionError, WithoutEffectError, need, refuse
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.bridges.page import page_url
from uwsim.cli.access import Tokens
from uwsim.cli.exit_codes import INCOMPLETE, INTERRUPTED
from uwsim.cli.flights import Out
from uwsim.cli.groups import with_default
from uwsim.cli.options import AsJson, Threads, listed_seeds, print_json
from uwsim.cli.values import exercises, readable, within
from uwsim.operator.cli.station import KEPT, kept_flights, station_server
from uwsim.recording.flight_options import RecordOptions

if TYPE_CHECKING:
    from uwsim.exercises import Exercise
    from uwsim.operator.station.flights.flights import Bounds


app = with_default("exercise", "Fly an exercise with goals, limits and events; check a sheet.", "Fly")


@app.command("fly")
def exercise(
    *,
    name: Annotated[
        str | None,
        typer.Argument(
            help="A packaged exercise, or the path of a YAML file. Without it, the packaged ones are listed.",
            show_default=False,
            autocompletion=exercises,
        ),
    ] = None,
    pilot: Annotated[
        Path | None,
        typer.Option(
            help="A Python file with `def mission(vehicle): yield ...`, which flies it headless.", callback=readable
        ),
    ] = None,
    serve: Annotated[bool, typer.Option("--serve", help="Serve it at the operator's station, for a person.")] = False,
    person: Annotated[
        str | None,
        typer.Option(
            help="Name of the pilot, on the score sheet. With --serve, by default the name that the pilot gives on "
            "the page."
        ),
    ] = None,
    lag: Annotated[
        float | None,
        typer.Option(
            help="With --serve: the acoustic lag [s], one way: commands and sight are late by it. Default: the "
            "exercise's own.",
            callback=within(0, 3),
        ),
    ] = None,
    seed: Annotated[
        str | None,
        typer.Option(
            help="Seed of random draws and of the layout. With --pilot also several, as 1,2,5-20: each is flown, and "
            "the sheets are joined to seeds.csv and seeds.json. Default: the exercise's own.",
            metavar="N[,N-N...]",
        ),
    ] = None,
    out: Out = Path("out"),
    recorded: RecordOptions,
    port: Annotated[
        int | None,
        typer.Option(
            help=f"Port of --serve; 0 chooses a free one. Default: {ROSBRIDGE_PORT}.", callback=within(0, 65535)
        ),
    ] = None,
    tokens: Tokens,
    keep_flights: Annotated[
        str | None,
        typer.Option(
            metavar="COUNT,MB",
            help="With --serve: how many flights, and how many MB, are kept in the folder flights of --out. Default: "
            f"{KEPT}.",
        ),
    ] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Fly an exercise with goals, limits and events.

    It is judged by the vehicle's true state. Writes score.json and sheet.html. Exits with 4 if the score is too low to
    pass; not with several seeds, whose scores are the result.
    """
    from uwsim.exercises import exercise_names, load_exercise
    from uwsim.exercises.certified import checked_person

    if name is None:
        _list({each: load_exercise(each) for each in exercise_names()}, as_json)
        return
    if not serve:
        need("--serve", lag=lag, port=port, **tokens.arguments, keep_flights=keep_flights)
    if serve == (pilot is not None):
        raise WithoutEffectError("needs either --pilot FILE, which flies it, or --serve, for a person")
    seeds = [] if seed is None else listed_seeds(seed, "--seed")
    found = load_exercise(name)
    if lag is not None:
        found = found.model_copy(update={"lag_s": lag})
    if seeds:
        found = found.model_copy(update={"seed": seeds[0]})
    named = "" if person is None else checked_person(person)
    if serve:
        if len(seeds) > 1:
            raise OptionError(f"--seed {seed}: must be one seed with --serve, since a person flies one after another")
        refuse("has no effect with --serve; the page's menu records", **recorded.arguments)
        refuse("has no effect with --serve; each attempt's score.json is in --out", json=as_json)
        bounds = kept_flights(KEPT if keep_flights is None else keep_flights)
        packaged = name if name in exercise_names() and lag is None else ""
        _serve(found, out, ROSBRIDGE_PORT if port is None else port, tokens, bounds, threads, named, packaged)
        return
    from uwsim.exercises.flight import fly_exercise
    from uwsim.exercises.sheet_text import score_lines
    from uwsim.flight.terminal import Silent, Terminal

    if len(seeds) > 1:
        parts = []
        for each in seeds:
            parts.append(out / f"seed-{each}")
            typer.echo(f"seed {each}: {parts[-1]}")
            flown = fly_exercise(
                found.model_copy(update={"seed": each}), pilot, parts[-1], person=named, threads=threads,
                screen=Silent(), **recorded.arguments,
            ).record  # fmt: skip
            if flown.interrupted:
                raise typer.Exit(INTERRUPTED)
        _join(out, parts, as_json)
        return
    course, flown = fly_exercise(
        found, pilot, out, person=named, threads=threads, screen=Terminal(), **recorded.arguments
    )
    if as_json:
        print_json(course.sheet())
    else:
        for row in score_lines(course.sheet()):
            typer.echo(row)
        typer.echo(f"{out / 'score.json'}  {out / 'sheet.html'}")
    if flown.interrupted:
        raise typer.Exit(INTERRUPTED)
    if not course.has_passed:
        raise typer.Exit(INCOMPLETE)


def _join(out: Path, parts: list[Path], as_json: bool) -> None:
    from uwsim.exercises.seed_table import mean_score, seed_row, write_table
    from uwsim.exercises.sheet import SCORE

    rows = [seed_row(part / SCORE) for part in parts]
    written = write_table(out, rows)
    if as_json:
        print_json(rows)
        return
    for row in rows:
        verdict = ("passed" if row["passed"] else "not passed") if row["valid"] else "not valid"
        typer.echo(
            f"seed {row['seed']:6}  {row['score']:6.1f} of {row['points']:g}  {row['time_s']:6.1f} s  {verdict:10}  "
            f"{row['pilot']}"
        )
    typer.echo(mean_score(rows))
    typer.echo("  ".join(map(str, written)))


def _list(found: dict[str, Exercise], as_json: bool) -> None:
    if as_json:
        print_json([
            {"name": name, "title": each.title, "points": each.points, "time_s": each.time_s, "scenario": each.scenario}
            for name, each in found.items()
        ])  # fmt: skip
        return
    for name, each in found.items():
        typer.echo(f"{name:14} {each.title} ({each.points:g} points, {each.time_s:g} s, {each.scenario})")


def _serve(
    found: Exercise, out: Path, port: int, tokens: Tokens, bounds: Bounds, threads: int | None, person: str, name: str,
) -> None:  # fmt: skip
    from uwsim.cli.run_live import wait_for_interrupt
    from uwsim.operator.station import Station

    hub = Station(is_fixed=True, truth=False, threads=threads, folder=out, keep_flights=bounds)
    with station_server(hub, port=port, **tokens.settings("127.0.0.1")) as server:
        hub.run_exercise(found, person, name)
        url = page_url(server.url, tokens.token)
        wait_for_interrupt(f"the exercise is at {url}; its sheets will be in {out}; Ctrl-C ends it")


@app.command()
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
