"""Made: what a reader of the group `uwsim.scenario_sources` makes, for `uwsim scenario from`."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from uwsim.base.reader import Reader, reader_of, readers
from uwsim.scenario.read.note import Note

GROUP = "uwsim.scenario_sources"
"""Each reader makes a scenario of a path, of the folder to write, or None for one named after the scenario, and of the
options of the command line that are among its own. It raises ValueError (of NotMadeError, the notes are printed) or
OSError, and then has written nothing."""


class Made(NamedTuple):
    """The scenario's file, and a note for each element that was left out or assumed."""

    path: Path
    notes: list[Note]


class NotMadeError(ValueError):
    """A source of which no scenario can be made. notes: for all that was read, left out or assumed before."""

    def __init__(self, rule: str, notes: list[Note]) -> None:
        super().__init__(rule)
        self.notes = notes


def source_of(path: Path) -> Reader:
    """Return the reader of a file or folder. Raises ValueError for one that none accepts, and OSError."""
    if not path.exists():
        raise FileNotFoundError(f"'{path}': there is no such file or folder")
    if (found := reader_of(GROUP, path)) is None:
        raise ValueError(f"'{path}': must be {', '.join(each.what for each in readers(GROUP).values())}")
    return found
