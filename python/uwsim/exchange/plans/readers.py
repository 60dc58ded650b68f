"""The missions' files that are read, in the group `uwsim.kinds.mission_file` of entry points."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

from uwsim.base.reader import Reader
from uwsim.base.texts.json_text import json_object
from uwsim.base.texts.text_file import decoded
from uwsim.exchange.plans import charts, plan_file
from uwsim.missions.field.mission import (
    BYTES_MAX,
    ITEMS_MAX,
    FieldFileError,
    FieldMission,
    Item,
    finite,
    lat_lon,
    number,
    whole,
)

BOM = b"\xef\xbb\xbf"
ARCHIVE = b"PK\x03\x04"
MAGIC = "QGC WPL "
VERSIONS = ("110", "120")
COLUMNS = 12


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


def _start(head: bytes) -> bytes:
    return head.removeprefix(BOM).lstrip()


def _is_kml(path: Path, head: bytes) -> bool:
    return path.suffix.lower() == ".kmz" if head.startswith(ARCHIVE) else _start(head)[:1] == b"<" and b"kml" in head


def _waypoints(data: bytes, name: str) -> FieldMission:
    """Return the mission. Raises FieldFileError.

    A line has number, current, frame, command, four parameters, latitude, longitude, altitude and autocontinue
    (https://mavlink.io/en/file_formats/). In version 110, item 0 is the home position; version 120 has none.
    """
    head, *lines = decoded(data, name, "text").lstrip().splitlines()
    version = head[len(MAGIC) :].strip()
    if version not in VERSIONS:
        raise FieldFileError(f"line 1: version '{version[:20]}': must be {' or '.join(VERSIONS)}")
    if len(lines) > 2 * ITEMS_MAX:
        raise FieldFileError(f"has {len(lines)} lines: must have at most {ITEMS_MAX} items")
    items: list[Item] = []
    home = None
    for k, line in enumerate(lines, 2):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            at, item = _item(line, len(items) + (version == "120" or home is not None))
        except FieldFileError as error:
            raise FieldFileError(f"line {k}: {error}") from None
        if version == "110" and home is None:
            home = at
        else:
            items.append(item)
    if len(items) > ITEMS_MAX:
        raise FieldFileError(f"has {len(items)} items: must have at most {ITEMS_MAX}")
    return FieldMission(tuple(items), home=home)


def _item(line: str, seq: int) -> tuple[tuple[float, float], Item]:
    words = line.split()
    if len(words) != COLUMNS:
        raise FieldFileError(f"has {len(words)} columns: must have {COLUMNS}")
    p1, p2, p3, p4 = (finite(word) if word.lower() != "nan" else 0.0 for word in words[4:8])
    frame, command = whole(words[2], "frame", 0, 255), whole(words[3], "command", 0, 65535)
    at = lat_lon(words[8:10], "position")
    z = number(words[10], "altitude", -1e6, 1e6, "m")
    return at, Item(seq, frame, command, p1, p2, p3, p4, round(1e7 * at[0]), round(1e7 * at[1]), z)


def _json(data: bytes, name: str) -> FieldMission:
    document = json_object(decoded(data, name, "text"), name)
    return charts.read_geojson(document) if document.get("type") in charts.TYPES else plan_file.read(document)


def _kml(data: bytes, name: str) -> FieldMission:
    data = unpacked(data).removeprefix(BOM) if data.startswith(ARCHIVE) else data
    return charts.read_kml(decoded(data, name, "text"), name)


WAYPOINTS = Reader("QGC WPL 110", lambda path, head: _start(head).startswith(MAGIC.encode()), _waypoints)
KML = Reader("KML or KMZ", _is_kml, _kml)
JSON = Reader("a QGroundControl plan or GeoJSON", lambda path, head: _start(head).startswith(b"{"), _json)
