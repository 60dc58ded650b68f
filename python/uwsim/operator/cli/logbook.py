"""`uwsim logbook`: the hours and exercises of each person."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.base.options import WithoutEffectError
from uwsim.cli.bounds import readable
from uwsim.cli.exit_codes import INCOMPLETE
from uwsim.cli.groups import under
from uwsim.cli.options import AsJson

if TYPE_CHECKING:
    from uwsim.exercises.logbook import Entry


@under("Fly")
def logbook(
    person: Annotated[
        str | None, typer.Option(help="Print this person's attempts. Without it, the totals of all persons.")
    ] = None,
    json: AsJson = False,
    csv: Annotated[bool, typer.Option("--csv", help="Print the attempts as CSV.")] = False,
    check: Annotated[
        Path | None,
        typer.Option(help="Only check that a score.json is as it was written, by its digest.", callback=readable),
    ] = None,
) -> None:
    """Print the hours and exercises of each person.

    The log book has each attempt of a named person that `uwsim exercise` has judged. The file is uwsim/logbook.jsonl in
    the folder of the user's data, or that in the environment variable UWSIM_LOGBOOK. Lines that are no entries, such as
    one that was cut short, are reported and left out; the exit code is then 4.
    """
    from uwsim.exercises.certified import checked_person, read_sheet
    from uwsim.exercises.logbook import RULE, logbook_path, read_book

    if check is not None:
        if person is not None or json or csv:
            raise WithoutEffectError("--person, --json and --csv: have no effect with --check")
        sheet = read_sheet(check)
        typer.echo(
            f"{check}: is as it was written: {sheet['person'] or 'not named'}, {sheet['title']}, {sheet['date']}"
        )
        return
    if json and csv:
        raise WithoutEffectError("needs only one of --json and --csv")
    path = logbook_path()
    if path is None:
        raise ValueError("UWSIM_LOGBOOK: is empty: there is no log book")
    wanted = None if person is None else checked_person(person)
    book = read_book(path)
    found = [each for each in book.entries if wanted is None or each.person == wanted]
    if json:
        typer.echo(_json(found))
    elif csv:
        typer.echo(_csv(found), nl=False)
    else:
        for line in _attempts(found) if wanted is not None else _totals(found):
            typer.echo(line)
        typer.echo(f"{path}: {len(found)} attempts")
    for number in book.unread:
        typer.echo(f"uwsim: warning: '{path}', line {number}: {RULE}; it is left out", err=True)
    if book.unread:
        raise typer.Exit(INCOMPLETE)


def _attempts(found: Sequence[Entry]) -> list[str]:
    return [
        f"{each.date:25}  {each.title}: {each.score:.1f} of {each.points:g} in {each.duration_s:.0f} s, "
        + ("passed" if each.has_passed else "not passed" if each.is_valid else "not valid")
        for each in found
    ]


def _totals(found: Sequence[Entry]) -> list[str]:
    from uwsim.exercises.logbook import totals

    return [
        f"{each['hours']:8.2f} h  {each['passed']} of {each['exercises']} exercises passed in {each['attempts']} "
        f"attempts  {person}"
        for person, each in totals(found).items()
    ]


def _json(found: Sequence[Entry]) -> str:
    import orjson

    return orjson.dumps([each.model_dump() for each in found], option=orjson.OPT_INDENT_2).decode()


def _csv(found: Sequence[Entry]) -> str:
    import csv

    from uwsim.exercises.logbook import Entry

    text = io.StringIO()
    writer = csv.DictWriter(text, list(Entry.model_fields), lineterminator="\n")
    writer.writeheader()
    writer.writerows(each.model_dump() for each in found)
    return text.getvalue()
