"""Reads a file of the field, whose format is known by its content."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path

from uwsim.base.texts.json_text import json_object
from uwsim.base.texts.text_file import decoded, read_limited
from uwsim.missions.field.mission import FieldFileError, FieldMission

FORMATS = "a QGroundControl plan, QGC WPL 110, GeoJSON, KML or KMZ"
BYTES_MAX = 20_000_000
HEAD_BYTES = 512
BOM = b"\xef\xbb\xbf"
ARCHIVE = b"PK\x03\x04"


def is_mission_file(path: Path) -> bool:
    """Return whether a file's content begins as one of the field's. Raises OSError."""
    if path.suffix == ".py" or not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    return path.suffix.lower() == ".kmz" if head.startswith(ARCHIVE) else _reader_of(head) is not None


def read_mission_file(path: str | Path) -> FieldMission:
    """Read a mission's file. Raises FieldFileError, which names it, or OSError."""
    path = Path(path)
    try:
        data = read_limited(path, str(path), BYTES_MAX)
        data = (unpacked(data) if data.startswith(ARCHIVE) else data).removeprefix(BOM)
        if (reader := _reader_of(data[:HEAD_BYTES])) is None:
            raise FieldFileError(f"{path}: is no mission's file: must be {FORMATS}")
        found = reader(decoded(data, str(path), "text"), str(path))
        if not found.items and not found.areas:
            raise FieldFileError("has nothing to fly")
    except ValueError as error:
        text = str(error)
        raise FieldFileError(text if text.startswith(f"{path}:") else f"{path}: {text}") from None
    return found


def unpacked(data: bytes) -> bytes:
    """Return the KML in a KMZ: doc.kml, or its only .kml (OGC 12-007r2, annex C). Raises FieldFileError."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            parts = [part for part in archive.infolist() if part.filename.lower().endswith(".kml")]
            named = [part for part in parts if part.filename == "doc.kml"] or parts
            if len(named) != 1:
                raise FieldFileError(f"is an archive with {len(parts)} .kml files: must be a KMZ with doc.kml")
            if named[0].file_size > BYTES_MAX:
                size = f"{named[0].filename:.40} unpacks to {named[0].file_size} bytes"
                raise FieldFileError(f"{size}: must be at most {BYTES_MAX}")
            return archive.read(named[0])  # of no more than its stated size
    except FieldFileError:
        raise
    except Exception as error:  # a damaged archive can make zipfile and its decompressors raise anything
        raise FieldFileError(f"is a damaged archive: {error}") from None


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
