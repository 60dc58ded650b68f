"""`uwsim exercise logbook`: the hours and exercises of each person."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.base.options import OptionError, WithoutEffectError, need, refuse
from uwsim.cli.bounds import readable
from uwsim.cli.exit_codes import INCOMPLETE
from uwsim.cli.options import AsJson

if TYPE_CHECKING:
    from uwsim.exercises.logbook import Book, Line


def logbook(
    person: Annotated[
        str | None, typer.Option(help="Print this person's attempts. Without it, the totals of all persons.")
    ] = None,
    json: AsJson = False,
    csv: Annotated[bool, typer.Option("--csv", help="Print the attempts as CSV.")] = False,
    check: Annotated[
        Path | None,
        typer.Option(
            help="Only check that a score.json or certificate.json is as it was written, and who has signed it.",
            callback=readable,
        ),
    ] = None,
    signed_by: Annotated[
        Path | None,
        typer.Option(help="With --check: the public key that must have signed it, Ed25519 as PEM.", callback=readable),
    ] = None,
    certificate: Annotated[
        Path | None,
        typer.Option(help="With --person: write certificate.json and certificate.html into this folder."),
    ] = None,
    sign: Annotated[
        Path | None,
        typer.Option(help="With --certificate: sign it with this key, Ed25519 as PEM.", callback=readable),
    ] = None,
) -> None:
    """Print the hours and exercises of each person.

    The log book has each attempt of a named person that `uwsim exercise` has judged. The file is uwsim/logbook.jsonl in
    the folder of the user's data, or that in the environment variable UWSIM_LOGBOOK. Lines that are no entries, such as
    one that was cut short, are reported and left out. Lines that are not as they were written are reported, shown as
    not valid, and count for no person; for either, the exit code is 4.
    """
    from uwsim.exercises.certified import checked_person
    from uwsim.exercises.logbook import RULE, logbook_path, read_book

    if check is not None:
        refuse("has no effect with --check", person=person, json=json or None, csv=csv or None,
               certificate=certificate, sign=sign)  # fmt: skip
        typer.echo(_checked(check, signed_by))
        return
    need("--check", signed_by=signed_by)
    if person is None:
        need("--person", certificate=certificate)
    if certificate is None:
        need("--certificate", sign=sign)
    else:
        refuse("has no effect with --certificate", json=json or None, csv=csv or None)
    if json and csv:
        raise WithoutEffectError("needs only one of --json and --csv")
    path = logbook_path()
    if path is None:
        raise ValueError("UWSIM_LOGBOOK: is empty: there is no log book")
    wanted = None if person is None else checked_person(person)
    book = read_book(path)
    found = [each for each in book.lines if wanted is None or each.entry.person == wanted]
    if certificate is not None:
        _certify(book, str(wanted), certificate, sign)
    elif json:
        typer.echo(_json(found))
    elif csv:
        typer.echo(_csv(found), nl=False)
    else:
        for line in _attempts(found) if wanted is not None else _totals(found):
            typer.echo(line)
        wrong = sum(each.check == "not valid" for each in found)
        typer.echo(f"{path}: {len(found)} attempts" + (f", {wrong} not valid" if wrong else ""))
    for number in book.unread:
        typer.echo(f"uwsim: warning: '{path}', line {number}: {RULE}; it is left out", err=True)
    refused = [each for each in book.lines if each.check == "not valid"]
    for each in refused:
        typer.echo(f"uwsim: warning: '{path}', line {each.number}: is not valid: {each.why}", err=True)
    if book.unread or refused:
        raise typer.Exit(INCOMPLETE)


def _checked(path: Path, key: Path | None) -> str:
    """Return a line about a sheet or a certificate that is as it was written. Raises ValueError for another."""
    from uwsim.exercises.certificate import check_certificate, is_certificate
    from uwsim.exercises.certified import read_sheet

    if is_certificate(path):
        return check_certificate(path, key)
    if key is not None:
        raise OptionError(f"--signed-by '{key}': a score sheet has no signature; a certificate may have one")
    sheet = read_sheet(path)
    return f"{path}: is as it was written: {sheet['person'] or 'not named'}, {sheet['title']}, {sheet['date']}"


def _certify(book: Book, person: str, folder: Path, key: Path | None) -> None:
    from uwsim.base.extras import need_extra
    from uwsim.base.signing import signed
    from uwsim.exercises.certificate import certificate_of, write_certificate

    need_extra("jinja2", "a certificate's page")
    made = certificate_of(book, person)
    written = write_certificate(folder, made if key is None else signed(made, key))
    typer.echo("  ".join(map(str, written)))


def _attempts(found: Sequence[Line]) -> list[str]:
    return [
        f"{each.date:25}  {each.title}: {each.score:.1f} of {each.points:g} in {each.duration_s:.0f} s, "
        + _verdict(line)
        for line, each in ((line, line.entry) for line in found)
    ]


def _verdict(line: Line) -> str:
    if line.check == "not valid":
        return f"not valid: line {line.number} of the log book: {line.why}"
    entry = line.entry
    return "passed" if entry.has_passed else "not passed" if entry.is_valid else "not valid"


def _totals(found: Sequence[Line]) -> list[str]:
    from uwsim.exercises.logbook import totals

    return [
        f"{each['hours']:8.2f} h  {each['passed']} of {each['exercises']} exercises passed in {each['attempts']} "
        f"attempts  {person}"
        for person, each in totals(line.entry for line in found if line.check != "not valid").items()
    ]


def _json(found: Sequence[Line]) -> str:
    import orjson

    return orjson.dumps([_row(each) for each in found], option=orjson.OPT_INDENT_2).decode()


def _csv(found: Sequence[Line]) -> str:
    import csv

    from uwsim.exercises.logbook import Entry

    text = io.StringIO()
    writer = csv.DictWriter(text, [*Entry.model_fields, "line_check"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(_row(each) for each in found)
    return text.getvalue()


def _row(line: Line) -> dict[str, Any]:
    return {**line.entry.model_dump(), "line_check": line.check}
