"""The log book: the attempts at exercises of each named person, in one file of JSON lines to which uwsim only appends.

The file is $UWSIM_LOGBOOK if set (empty: no log book), otherwise uwsim/logbook.jsonl in $XDG_DATA_HOME or
~/.local/share. Each line has a digest of its values, and that of the bytes of the line before it, so that a line that
was changed, removed or inserted is noticed. As with a sheet's digest, they show mistakes, not the fraud of one who
computes them again, nor the removal of the last lines.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict

from uwsim.base.texts.json_text import json_object
from uwsim.exercises.certified import bytes_digest, digest_of

NAME = "logbook.jsonl"
RULE = "is not an entry of a log book"
BEGIN = b'{"date":"'
PREVIOUS, OWN = "previous", "line_digest"
Check = Literal["valid", "not valid"]


class Entry(BaseModel):
    """One attempt, as in its score sheet. date: ISO 8601, of its end. duration_s: simulated. digest: the sheet's.

    task: the kind of work, "" in lines of before it was kept.
    """

    model_config = ConfigDict(extra="ignore", strict=True)

    date: str
    person: str
    title: str
    scenario: str
    seed: int
    attempt: int
    duration_s: float
    score: float
    points: float
    is_valid: bool
    has_passed: bool
    ended_because: str
    build: str
    digest: str
    task: str = ""

    @classmethod
    def of(cls, sheet: Mapping[str, Any]) -> Entry:
        """Return the entry of a certified sheet."""
        return cls(**{name: sheet["time_s" if name == "duration_s" else name] for name in cls.model_fields})


def logbook_path() -> Path | None:
    """Return the log book's path, or None if there is none."""
    chosen = os.environ.get("UWSIM_LOGBOOK")
    if chosen is not None:
        return Path(chosen) if chosen else None
    with contextlib.suppress(RuntimeError):  # no home directory
        return Path(os.environ.get("XDG_DATA_HOME") or "~/.local/share").expanduser() / "uwsim" / NAME
    return None


def log_attempt(sheet: Mapping[str, Any]) -> Path | None:
    """Append a certified sheet's entry; return the file, or None for an unnamed person.

    Raises OSError, or ValueError for a file that is no log book, to which nothing is added.
    """
    path = logbook_path()
    if not sheet["person"] or path is None:
        return None
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # several stations may share the file
        file.seek(0)
        data = file.read()
        lines = _lines(data, path)
        values = {**Entry.of(sheet).model_dump(), PREVIOUS: _digest_before(lines, len(lines))}
        text = json.dumps({**values, OWN: digest_of(values, OWN)}, ensure_ascii=False, separators=(",", ":"))
        is_cut = data != b"" and not data.endswith(b"\n")
        file.write(b"\n" * is_cut + text.encode() + b"\n")
        file.flush()
        os.fsync(file.fileno())
    return path


class Line(NamedTuple):
    """An attempt as a line of the book has it. number: of the line, from 1.

    check: "valid" if the line is as it was written, else "not valid". why: the reason for that, or "".
    """

    number: int
    entry: Entry
    check: Check
    why: str


class Book(NamedTuple):
    """A log book's lines in order, and the numbers of those that are no entries, such as one that was cut short."""

    lines: list[Line]
    unread: list[int]

    @property
    def entries(self) -> list[Entry]:
        """The attempts of all lines, also of those that are not valid."""
        return [line.entry for line in self.lines]


def read_book(path: Path) -> Book:
    """Read and check a log book; a missing file has no entries.

    Raises OSError, or ValueError for a file that is no log book.
    """
    book, data = Book([], []), b""
    with contextlib.suppress(FileNotFoundError):
        data = path.read_bytes()
    lines = _lines(data, path)
    for k, (_, values) in enumerate(lines):
        if values is None:
            book.unread.append(k + 1)
            continue
        why = _why_not(lines, k)
        book.lines.append(Line(k + 1, Entry.model_validate(values), "not valid" if why else "valid", why))
    return book


Read = tuple[bytes, dict[str, Any] | None]
"""A line, and its values if it is an entry."""


def _lines(data: bytes, path: Path) -> list[Read]:
    """Return a book's lines. Raises ValueError unless there is an entry, or nothing but lines cut short."""
    texts = data.removesuffix(b"\n").split(b"\n") if data else []
    lines = [(text, _entry_values(text)) for text in texts]
    is_cut = all(text and (text.startswith(BEGIN) or BEGIN.startswith(text)) for text in texts)
    if not is_cut and all(values is None for _, values in lines):
        raise ValueError(f"'{path}', line 1: {RULE}")
    return lines


def _entry_values(text: bytes) -> dict[str, Any] | None:
    try:
        values = json_object(text, NAME)
        Entry.model_validate(values)
    except ValueError:
        return None
    return values


def _digest_before(lines: Sequence[Read], k: int) -> str:
    """Return the digest of the line before a line, "" if it is the first."""
    return bytes_digest(lines[k - 1][0]) if k else ""


def _is_own(values: Mapping[str, Any]) -> bool:
    return OWN in values and digest_of(values, OWN) == values[OWN]


def _why_not(lines: Sequence[Read], k: int) -> str:
    """Return why an entry does not check, or ""."""
    values, after = lines[k][1], lines[k + 1][1] if k + 1 < len(lines) else None
    assert values is not None
    if OWN not in values:
        return "it has no digest"
    if not _is_own(values):
        return "it was changed after it was written"
    if k == 0 and values.get(PREVIOUS, "") != "":
        return "lines before it were removed"
    if after is not None and _is_own(after) and after.get(PREVIOUS) != _digest_before(lines, k + 1):
        return "the next line was written after another one: this one was changed or inserted, or lines were removed"
    return ""


def best_scores() -> dict[str, float]:
    """Return the best valid score of each exercise, by title, over all persons of the log book, if it can be read."""
    best: dict[str, float] = {}
    with contextlib.suppress(OSError, ValueError):
        path = logbook_path()
        for line in [] if path is None else read_book(path).lines:
            if line.check == "valid" and line.entry.is_valid:
                best[line.entry.title] = max(line.entry.score, best.get(line.entry.title, 0.0))
    return best


def totals(found: Iterable[Entry]) -> dict[str, dict[str, Any]]:
    """Return exercises, passed, attempts and hours by person. exercises, passed: different titles."""
    by_person: dict[str, list[Entry]] = {}
    for each in found:
        by_person.setdefault(each.person, []).append(each)
    return {
        person: {
            "exercises": len({each.title for each in own}),
            "passed": len({each.title for each in own if each.has_passed}),
            "attempts": len(own),
            "hours": sum(each.duration_s for each in own) / 3600.0,
        }
        for person, own in by_person.items()
    }
