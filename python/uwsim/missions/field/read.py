"""Reads a file of the field by its content: by a reader of the group GROUP."""

from __future__ import annotations

from pathlib import Path

from uwsim.base.reader import reader_of, readers
from uwsim.base.texts.text_file import read_limited
from uwsim.missions.field.mission import FieldFileError, FieldMission

GROUP = "uwsim.kinds.mission_file"
"""Each reader returns a FieldMission of a file's bytes and its name."""
BYTES_MAX = 20_000_000


def is_mission_file(path: Path) -> bool:
    """Return whether a file's content begins as one of the field's. Raises OSError."""
    return path.suffix != ".py" and path.is_file() and reader_of(GROUP, path) is not None


def read_mission_file(path: str | Path) -> FieldMission:
    """Read a mission's file. Raises FieldFileError, which names it, or OSError."""
    path = Path(path)
    try:
        data = read_limited(path, str(path), BYTES_MAX)
        if (reader := reader_of(GROUP, path)) is None:
            known = ", ".join(each.what for each in readers(GROUP).values())
            raise FieldFileError(f"{path}: is no mission's file: must be {known}")
        found: FieldMission = reader.read(data, str(path))
        if not found.items and not found.areas:
            raise FieldFileError("has nothing to fly")
    except ValueError as error:
        text = str(error)
        raise FieldFileError(text if text.startswith(f"{path}:") else f"{path}: {text}") from None
    return found
