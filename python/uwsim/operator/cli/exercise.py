"""`uwsim exercise`: fly an exercise with a script as its pilot, or serve it at the operator's station."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.base.options import OptionError, WithoutEffectError, need, refuse
from uwsim.bridges.page import page_url
from uwsim.cli.access import Tokens
from uwsim.cli.bounds import readable, within
from uwsim.cli.exit_codes import INCOMPLETE, INTERRUPTED
from uwsim.cli.flights import Out
from uwsim.cli.groups import with_default
from uwsim.cli.options import AsJson, Threads, print_json
from uwsim.cli.seeds import listed_seeds
from uwsim.cli.values import exercises
from uwsim.operator.cli.station import KEPT, kept_flights, station_server
from uwsim.recording.flight_options import RecordOptions

if TYPE_CHECKING:
    from uwsim.exercises import Exercise
    from uwsim.operator.station.flights.flights import Bounds


app = with_default("exercise", "Fly an exercise with goals, limits and events; the log book.", "Fly")


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
            help="Name of the pilot, on the score sheet and in the log book (uwsim exercise logbook). With --serve, "
            "by default the name that the pilot gives on the page."
        ),
    ] = None,
    lag: Annotated[
        str | None,
        typer.Option(
            help="The acoustic lag [s], one way, 0 to 3: commands and sight are late by it. With --pilot also several, "
            "as 0,0.5,1,2: each is flown, and the sheets are joined. Default: the exercise's own.",
            metavar="S[,S...]",
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
    join: Annotated[
        list[Path] | None,
        typer.Option(
            help="Instead of flying: join the score sheets in a folder to lags.csv, lags.json, lags.png; repeatable.",
            show_default=False,
        ),
    ] = None,
    out: Out = Path("out"),
    recorded: RecordOptions,
    port: Annotated[
        int | None,
        typer.Option(help="Port of --serve; 0 chooses a free one. Default: 9090.", callback=within(0, 65535)),
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

    It is judged by the vehicle's true state. Writes score.json and sheet.html, the debriefing. Exits with 4 if the
    score is too low to pass; not with several lags, whose scores are the result.
    """
    from uwsim.exercises import exercise_names, load_exercise
    from uwsim.exercises.certified import checked_person

    if join:
        refuse("has no effect with --join, which flies nothing", name=name, pilot=pilot, serve=serve or None,
               person=person, lag=lag, seed=seed, **recorded.arguments)  # fmt: skip
        from uwsim.exercises.lag_table import LAGS, sheets_in

        _join(out, sheets_in(join), LAGS, as_json)
        return
    if name is None:
        _list({each: load_exercise(each) for each in exercise_names()}, as_json)
        return
    if not serve:
        need("--serve", port=port, **tokens.arguments, keep_flights=keep_flights)
    if serve == (pilot is not None):
        raise WithoutEffectError("needs either --pilot FILE, which flies it, or --serve, for a person")
    lags, seeds = _lags(lag), [] if seed is None else listed_seeds(seed, "--seed")
    found = load_exercise(name)
    if lags:
        found = found.model_copy(update={"lag_s": lags[0]})
    if seeds:
        found = found.model_copy(update={"seed": seeds[0]})
    named = "" if person is None else checked_person(person)
    if serve:
        if len(lags) > 1:
            raise OptionError(f"--lag {lag}: must be one lag with --serve, since a person flies one after another")
        if len(seeds) > 1:
            raise OptionError(f"--seed {seed}: must be one seed with --serve, since a person flies one after another")
        refuse("has no effect with --serve; the page's menu records", **recorded.arguments)
        refuse("has no effect with --serve; each attempt's score.json is in --out", json=as_json)
        bounds = kept_flights(KEPT if keep_flights is None else keep_flights)
        packaged = name if name in exercise_names() and not lags else ""
        _serve(found, out, 9090 if port is None else port, tokens, bounds, threads, named, packaged)
        return
    from uwsim.exercises.flight import fly_exercise
    from uwsim.exercises.sheet_text import score_lines
    from uwsim.flight.terminal import Silent, Terminal

    if len(lags) > 1 and len(seeds) > 1:
        raise OptionError(f"--lag {lag} --seed {seed}: several of only one of them")
    if len(lags) > 1 or len(seeds) > 1:
        from uwsim.exercises.lag_table import LAGS, SEEDS, sheets_in

        stem = LAGS if len(lags) > 1 else SEEDS
        parts = []
        for each in lags if stem == LAGS else seeds:
            parts.append(out / f"{stem.removesuffix('s')}-{each:g}")
            typer.echo(f"lag {each:g} s, one way: {parts[-1]}" if stem == LAGS else f"seed {each}: {parts[-1]}")
            flown = fly_exercise(
                found.model_copy(update={"lag_s" if stem == LAGS else "seed": each}), pilot, parts[-1], person=named,
                threads=threads, screen=Silent(), **recorded.arguments,
            ).record  # fmt: skip
            if flown.interrupted:
                raise typer.Exit(INTERRUPTED)
        _join(out, sheets_in(parts), stem, as_json)
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


def _lags(text: str | None) -> list[float]:
    """Return the lags of an option. Raises OptionError."""
    from uwsim.exercises.lag import LAG_MAX_S

    found: list[float] = []
    for part in [] if text is None else text.split(","):
        try:
            found.append(float(part))
        except ValueError:
            found.append(math.nan)
        if not 0.0 <= found[-1] <= LAG_MAX_S:
            raise OptionError(f"--lag {text}: {part.strip() or 'nothing'} s: must be in [0, {LAG_MAX_S:g}] s")
    if len(set(found)) < len(found):
        raise OptionError(f"--lag {text}: must be different lags")
    return found


def _join(out: Path, sheets: list[Path], stem: str, as_json: bool) -> None:
    from uwsim.exercises.lag_table import SEEDS, lag_rows, mean_score, write_table

    rows = lag_rows(sheets)
    written = write_table(out, rows, stem)
    if as_json:
        print_json(rows)
        return
    for row in rows:
        verdict = ("passed" if row["passed"] else "not passed") if row["valid"] else "not valid"
        typer.echo(
            (f"seed {row['seed']:6}  " if stem == SEEDS else f"lag {row['lag_s']:4g} s  ")
            + f"{row['score']:6.1f} of {row['points']:g}  {row['time_s']:6.1f} s  {verdict:10}  {row['pilot']}"
        )
    if stem == SEEDS:
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
