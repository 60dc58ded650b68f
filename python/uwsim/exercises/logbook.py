"""The log book: the attempts at exercises of each named person, in one file of JSON lines to which uwsim only appends.

The file is $UWSIM_LOGBOOK if set (empty: no log book), otherwise uwsim/logbook.jsonl in $XDG_DATA_HOME or
~/.local/share.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ConfigDict

from uwsim.base.texts.json_text import json_value

NAME, LINE_MAX = "logbook.jsonl", 100_000
RULE = "is not an entry of a log book"


class Entry(BaseModel):
    """One attempt, as in its score sheet. date: ISO 8601, of its end. duration_s: simulated. digest: the sheet's."""

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
    line = Entry.of(sheet).model_dump_json().encode() + b"\n"
    with path.open("a+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # several stations may share the file
        file.seek(0)
        if first := file.readline(LINE_MAX):
            _entry(first, f"'{path}', line 1")
            file.seek(-1, os.SEEK_END)
            if file.read(1) != b"\n":  # a line that was cut short
                line = b"\n" + line
        file.write(line)
        file.flush()
        os.fsync(file.fileno())
    return path


class Book(NamedTuple):
    """A log book's entries in order, and the numbers of the lines that are none, such as one that was cut short."""

    entries: list[Entry]
    unread: list[int]


def read_book(path: Path) -> Book:
    """Read a log book; a missing file has no entries.

    Raises OSError, or ValueError for a file in which no line is an entry.
    """
    book = Book([], [])
    with contextlib.suppress(FileNotFoundError), path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            try:
                book.entries.append(_entry(line, f"'{path}', line {number}"))
            except ValueError:
                book.unread.append(number)
    if book.unread and not book.entries:
        raise ValueError(f"'{path}', line {book.unread[0]}: {RULE}")
    return book


def _entry(line: bytes, where: str) -> Entry:
    try:
        return Entry.model_validate(json_value(line, where))
    except ValueError:
        raise ValueError(f"{where}: {RULE}") from None


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
