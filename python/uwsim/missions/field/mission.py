"""FieldMission: what is read from a file of the field, whatever its format."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from uwsim.base.reader import reader_of, readers
from uwsim.base.texts.text_file import read_limited
from uwsim.missions.fence import Zone
from uwsim.missions.items import WAYPOINT

LatLon = tuple[float, float]
ITEMS_MAX, CORNERS_MAX = 20_000, 10_000


class FieldFileError(ValueError):
    """Raised for a file of the field that cannot be read; the message names the place in it."""


@dataclass
class Item:
    """An item with the fields of MISSION_ITEM_INT: x, y are latitude and longitude in 1e-7 deg."""

    seq: int
    frame: int
    command: int
    param1: float = 0.0
    param2: float = 0.0
    param3: float = 0.0
    param4: float = 0.0
    x: int = 0
    y: int = 0
    z: float = 0.0


class Area(NamedTuple):
    """An area to survey. corners: latitude, longitude [deg] in order around it. The other values are the file's own.

    heading_deg: of the lanes, clockwise from north. spacing_m: distance between them. altitude_m: above the bed.
    in_items: whether the items fly it already.
    """

    name: str
    corners: tuple[LatLon, ...]
    heading_deg: float | None = None
    spacing_m: float | None = None
    altitude_m: float | None = None
    in_items: bool = False


@dataclass(frozen=True)
class FieldMission:
    """A mission of the field.

    items: in the order of flight, numbered from 1. areas: polygons to survey. home: the planned home position. fence:
    zones to stay in or out of. notes: a sentence for each thing in the file that is not flown, or in another way.
    """

    items: tuple[Item, ...] = ()
    areas: tuple[Area, ...] = ()
    home: LatLon | None = None
    notes: tuple[str, ...] = ()
    fence: tuple[Zone, ...] = ()


def number(value: Any, what: str, low: float, high: float, unit: str = "") -> float:
    """Return a finite number of a file. Raises FieldFileError, which names it, its range and its unit."""
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            raise FieldFileError(f"{what} = '{value[:40]}': must be a number") from None
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not low <= value <= high:
        raise FieldFileError(f"{what} = {value!r:.40} {unit}".rstrip() + f": must be in [{low:g}, {high:g}]")
    return float(value)


def whole(value: Any, what: str, low: int, high: int) -> int:
    """Return a whole number of a file. Raises FieldFileError."""
    found = number(value, what, low, high)
    if found != int(found):
        raise FieldFileError(f"{what} = {found:g}: must be a whole number")
    return int(found)


def lat_lon(pair: Any, what: str) -> LatLon:
    """Return a latitude and a longitude of a file. Raises FieldFileError."""
    if not isinstance(pair, list | tuple) or len(pair) < 2:
        raise FieldFileError(f"{what} = {pair!r:.40}: must be [latitude, longitude]")
    return number(pair[0], f"{what}: latitude", -90, 90, "deg"), number(pair[1], f"{what}: longitude", -180, 180, "deg")


def ring(points: Iterable[Any], what: str) -> tuple[LatLon, ...]:
    """Return a polygon's corners of a file, without the first one repeated. Raises FieldFileError."""
    corners = [lat_lon(point, f"{what}, corner {k}") for k, point in enumerate(points, 1)]
    if len(corners) > 1 and corners[0] == corners[-1]:
        corners.pop()
    if not 3 <= len(corners) <= CORNERS_MAX:
        raise FieldFileError(f"{what}: has {len(corners)} corners: must be in [3, {CORNERS_MAX}]")
    return tuple(corners)


def waypoint(seq: int, at: LatLon, z: float, frame: int) -> Item:
    """Return a waypoint."""
    return Item(seq, frame, WAYPOINT, x=round(1e7 * at[0]), y=round(1e7 * at[1]), z=z)


def sentence(what: str, items: Sequence[int], then: str) -> str:
    """Return a sentence about some items, by number: the first ones, and how many there are."""
    shown = ", ".join(map(str, items[:5])) + (f" and {len(items) - 5} more" if len(items) > 5 else "")
    return f"item{'s' * (len(items) > 1)} {shown}: {what}: {then}"


def finite(value: Any) -> float:
    """Return a parameter of an item; 0 for null, which stands for a default."""
    found = 0.0 if value is None else number(value, "parameter", -1e12, 1e12)
    return 0.0 if math.isnan(found) else found


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
