"""Reads a file of the field, whose format is known by its content."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from uwsim.base.texts.json_text import json_object
from uwsim.base.texts.text_file import decoded, read_limited
from uwsim.missions.field.mission import FieldFileError, FieldMission

FORMATS = "a QGroundControl plan, QGC WPL 110, GeoJSON or KML"
BYTES_MAX = 20_000_000
HEAD_BYTES = 512
BOM = b"\xef\xbb\xbf"


def is_mission_file(path: Path) -> bool:
    """Return whether a file's content begins as one of the field's. Raises OSError."""
    if path.suffix == ".py" or not path.is_file():
        return False
    with path.open("rb") as file:
        return _reader_of(file.read(HEAD_BYTES)) is not None


def read_mission_file(path: str | Path) -> FieldMission:
    """Read a mission's file. Raises FieldFileError, which names it, or OSError."""
    path = Path(path)
    try:
        data = read_limited(path, str(path), BYTES_MAX).removeprefix(BOM)
        if (reader := _reader_of(data[:HEAD_BYTES])) is None:
            raise FieldFileError(f"{path}: is no mission's file: must be {FORMATS}")
        found = reader(decoded(data, str(path), "text"), str(path))
        if not found.items and not found.areas:
            raise FieldFileError("has nothing to fly")
    except ValueError as error:
        text = str(error)
        raise FieldFileError(text if text.startswith(f"{path}:") else f"{path}: {text}") from None
    return found


def _reader_of(head: bytes) -> Callable[[str, str], FieldMission] | None:
    start = head.removeprefix(BOM).lstrip()
    if start.startswith(b"QGC WPL "):
        from uwsim.missions.field.waypoints_file import read

        return lambda text, name: read(text.lstrip())
    if start.startswith(b"<"):
        return _kml if b"kml" in head else None
    return _json if start.startswith(b"{") else None


def _json(text: str, name: str) -> FieldMission:
    from uwsim.missions.field import geojson_file, plan_file

    document = json_object(text, name)
    return geojson_file.read(document) if document.get("type") in geojson_file.TYPES else plan_file.read(document)


def _kml(text: str, name: str) -> FieldMission:
    from uwsim.missions.field.kml_file import read

    return read(text, name)
