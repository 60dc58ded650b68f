"""The .waypoints files of Mission Planner, MAVProxy and QGroundControl (QGC WPL 110, 120).

A line has number, current, frame, command, four parameters, latitude, longitude, altitude and autocontinue
(https://mavlink.io/en/file_formats/). In version 110, item 0 is the home position; version 120 has none.
"""

from __future__ import annotations

from uwsim.missions.field.mission import ITEMS_MAX, FieldFileError, FieldMission, Item, finite, lat_lon, number, whole

MAGIC = "QGC WPL "
VERSIONS = ("110", "120")
COLUMNS = 12


def read(text: str) -> FieldMission:
    """Return the mission. Raises FieldFileError."""
    head, *lines = text.splitlines()
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
