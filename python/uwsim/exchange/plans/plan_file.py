"""The .plan files of QGroundControl (https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html).

Of surveys and corridors, the items are taken into which QGroundControl has expanded them, or else the points of their
transects. Without either, a survey is an area, and a corridor has lanes beside its line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.georeference import Home
from uwsim.missions.fence import Zone
from uwsim.missions.field.mission import (
    ITEMS_MAX,
    Area,
    FieldFileError,
    FieldMission,
    Item,
    LatLon,
    finite,
    lat_lon,
    number,
    ring,
    sentence,
    waypoint,
    whole,
)
from uwsim.missions.items import JUMP, LEFT_OUT

TRANSECTS = ("survey", "CorridorScan")
ZONES_MAX = 100
FRAME_OF_DISTANCE = {1: 3, 2: 0, 3: 10, 4: 10}
"""MAV_FRAME by QGroundControl's mode of altitude: above home, above sea, and twice above the terrain."""

LEAST_SPACING_M = 0.5
"""Below it, QGroundControl flies the line alone (CorridorScanComplexItem, `_calcTransectSpacing`)."""
TURN_MAX_DEG = 160.0


def read(document: dict[str, Any]) -> FieldMission:
    """Return the mission. Raises FieldFileError."""
    if document.get("fileType") != "Plan":
        raise FieldFileError(f"fileType = {document.get('fileType')!r:.40}: must be 'Plan'")
    mission = _of(document, "mission", dict)
    home = mission.get("plannedHomePosition")
    items: list[Item] = []
    notes: list[str] = []
    numbers: dict[int, int] = {}
    areas: list[Area] = []
    for k, entry in enumerate(_of(mission, "items", list), 1):
        where = f"mission.items[{k - 1}]"
        if not isinstance(entry, dict):
            raise FieldFileError(f"{where} = {entry!r:.40}: must be an object")
        try:
            for item, own in _expanded(entry, len(items) + 1, notes, areas):
                items.append(item)
                if own is not None:
                    numbers[own] = item.seq
        except FieldFileError as error:
            raise FieldFileError(f"{where}: {error}") from None
        if len(items) > ITEMS_MAX:
            raise FieldFileError(f"has more than {ITEMS_MAX} items")
    for n, item in enumerate(items):
        if item.command == JUMP:  # to a doJumpId
            if int(item.param1) not in numbers:
                raise FieldFileError(f"item {item.seq}: jumps to doJumpId {item.param1:g}, which no item has")
            items[n] = replace(item, param1=float(numbers[int(item.param1)]))
    if rally := _shapes(document, "rallyPoints", "points"):
        notes.append(f"rallyPoints: {len(rally)} points: left out")
    place = None if home is None else lat_lon(home, "mission.plannedHomePosition")
    return FieldMission(tuple(items), tuple(areas), place, tuple(notes), tuple(_fence(document)))


def _shapes(document: dict[str, Any], key: str, name: str) -> list[Any]:
    """Return a list in a part of a document that may be missing. Raises FieldFileError for one of another type."""
    part = document.get(key)
    return _of(part, name, list) if isinstance(part, dict) and part.get(name) is not None else []


def _fence(document: dict[str, Any]) -> Iterator[Zone]:
    """Yield the zones of a document's fence, polygons first. Raises FieldFileError."""
    shapes = [("polygons", each) for each in _shapes(document, "geoFence", "polygons")]
    shapes += [("circles", each) for each in _shapes(document, "geoFence", "circles")]
    if len(shapes) > ZONES_MAX:
        raise FieldFileError(f"geoFence: has {len(shapes)} zones: must have at most {ZONES_MAX}")
    for k, (key, each) in enumerate(shapes, 1):
        where = f"geoFence zone {k} of {key}"
        is_in = each.get("inclusion", True) if isinstance(each, dict) else None
        if not isinstance(is_in, bool):
            raise FieldFileError(f"{where} = {each!r:.40}: must be an object with inclusion = true or false")
        try:
            if key == "polygons":
                yield Zone(is_in, ring(_of(each, "polygon", list), "polygon"))
                continue
            circle = _of(each, "circle", dict)
            radius_m = number(circle.get("radius"), "radius", 0.01, 1e5, "m")
            yield Zone(is_in, (lat_lon(circle.get("center"), "center"),), radius_m)
        except FieldFileError as error:
            raise FieldFileError(f"{where}: {error}") from None


def _of(document: dict[str, Any], key: str, kind: type) -> Any:
    """Return a member of an object. Raises FieldFileError if it is missing or of another type."""
    found = document.get(key)
    if not isinstance(found, kind):
        raise FieldFileError(f"{key} = {found!r:.40}: must be {'an object' if kind is dict else 'a list'}")
    return found


def _expanded(
    entry: dict[str, Any], seq: int, notes: list[str], areas: list[Area]
) -> Iterator[tuple[Item, int | None]]:
    """Yield the items of an entry, each with its doJumpId."""
    if entry.get("type") == "SimpleItem":
        yield _simple(entry, seq), _jump_id(entry)
        return
    kind = entry.get("complexItemType")
    transects = entry.get("TransectStyleComplexItem")
    if entry.get("type") != "ComplexItem" or kind not in TRANSECTS or not isinstance(transects, dict):
        what = f"{entry.get('type')} {kind or ''}".strip()[:60]
        notes.append(sentence(what, [seq], "left out"))
        yield Item(seq, 2, LEFT_OUT), _jump_id(entry)
        return
    has_transects = bool(transects.get("Items") or transects.get("VisualTransectPoints"))
    if kind == "survey" and ("polygon" in entry or not has_transects):
        areas.append(_area(entry, transects.get("CameraCalc"), f"survey {len(areas) + 1}", has_transects))
    if not has_transects and kind == "survey":
        return
    if transects.get("Items"):
        for n, each in enumerate(_of(transects, "Items", list)):
            if not isinstance(each, dict):
                raise FieldFileError(f"Items[{n}] = {each!r:.40}: must be an object")
            yield _simple(each, seq + n), _jump_id(each)
        return
    calc = _of(transects, "CameraCalc", dict)
    if has_transects:
        points, way = _of(transects, "VisualTransectPoints", list), "its transects' points"
    else:
        points = corridor_points(entry, calc.get("AdjustedFootprintSide"), transects.get("TurnAroundDistance"))
        way = "lanes by its line, width and spacing"
    frame = FRAME_OF_DISTANCE.get(whole(calc.get("DistanceMode", 1), "CameraCalc.DistanceMode", 0, 10), 3)
    z = number(calc.get("DistanceToSurface"), "CameraCalc.DistanceToSurface", -1e6, 1e6, "m")
    notes.append(sentence(str(kind), [seq], f"the file has no expanded items: flown along {way}"))
    for n, point in enumerate(points):
        yield waypoint(seq + n, lat_lon(point, f"VisualTransectPoints[{n}]"), z, frame), None


def _area(entry: dict[str, Any], calc: Any, name: str, in_items: bool) -> Area:
    """Return the area of a survey, with the direction and the distance of its transects."""
    calc = calc if isinstance(calc, dict) else {}
    angle, spacing = entry.get("angle"), calc.get("AdjustedFootprintSide")
    return Area(
        name,
        ring(_of(entry, "polygon", list), "polygon"),
        None if angle is None else number(angle, "angle", -360, 360, "deg") % 360,
        number(spacing, "CameraCalc.AdjustedFootprintSide", 0, 1e6, "m") if spacing else None,
        in_items=in_items,
    )


def _jump_id(entry: dict[str, Any]) -> int | None:
    return entry["doJumpId"] if isinstance(entry.get("doJumpId"), int) else None


def _simple(entry: dict[str, Any], seq: int) -> Item:
    params = entry.get("params")
    if not isinstance(params, list) or len(params) != 7:
        raise FieldFileError(f"params = {params!r:.40}: must be a list of 7 numbers")
    frame, command = whole(entry.get("frame"), "frame", 0, 255), whole(entry.get("command"), "command", 0, 65535)
    values = [finite(value) for value in params]
    if frame == 2:  # no position: other parameters
        x, y = (1e-7 * value for value in values[4:6])
    else:
        x, y = lat_lon(values[4:6], "position")
    p1, p2, p3, p4, _, _, z = values
    return Item(seq, frame, command, p1, p2, p3, p4, round(1e7 * x), round(1e7 * y), z)


def corridor_points(entry: Mapping[str, Any], spacing: Any, turnaround: Any) -> list[LatLon]:
    """Return the points of a corridor's lanes in their order of flight. Raises FieldFileError.

    The lanes, of which there are ceil(width / spacing), lie symmetrically about the polyline, the first one to port of
    it, and every other one is flown backwards. The entry point 1 or 3 begins at the last lane, 2 or 3 at the end of the
    line. turnaround: how far [m] lanes go on beyond the line.
    """
    line = entry.get("polyline")
    if not isinstance(line, list) or not 2 <= len(line) <= ITEMS_MAX:
        raise FieldFileError(f"polyline = {line!r:.40}: must have 2 to {ITEMS_MAX} points")
    points = [lat_lon(point, f"polyline, point {k}") for k, point in enumerate(line, 1)]
    width_m = number(entry.get("CorridorWidth"), "CorridorWidth", 0, 1e5, "m")
    spacing_m = number(spacing or 0.0, "CameraCalc.AdjustedFootprintSide", 0, 1e6, "m")
    beyond_m = number(turnaround or 0.0, "TurnAroundDistance", 0, 1e4, "m")
    start = whole(entry.get("EntryPoint", 0), "EntryPoint", 0, 3)
    count = max(math.ceil(width_m / spacing_m), 1) if spacing_m >= LEAST_SPACING_M else 1
    if count * len(points) > ITEMS_MAX:
        raise FieldFileError(
            f"CorridorWidth = {width_m:g} m with lanes {spacing_m:g} m apart: more than {ITEMS_MAX} points"
        )
    place = Home(*points[0])
    line_m = np.array([place.world_m(*point, 0.0)[:2] for point in points])
    line_m = line_m[np.append(True, np.linalg.norm(np.diff(line_m, axis=0), axis=1) > 1e-3)]
    if len(line_m) < 2:
        raise FieldFileError("polyline: has no length")
    offsets_m = [width_m / 2.0 - spacing_m * (k + 0.5) for k in range(count)] if count > 1 else [0.0]
    lanes = [_beside(line_m, offset_m, beyond_m) for offset_m in offsets_m]
    lanes = lanes[::-1] if start in (1, 3) else lanes
    flown = [lane[::-1] if (k % 2 == 1) != (start in (2, 3)) else lane for k, lane in enumerate(lanes)]
    return [place.degrees(np.array([x, y, 0.0])) for lane in flown for x, y in lane.tolist()]


def _beside(line_m: NDArray[np.float64], offset_m: float, beyond_m: float) -> NDArray[np.float64]:
    """Return a line (n, 2) to port of another one at a distance, mitred at its corners, and extended at its ends."""
    along = np.diff(line_m, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    before, after = np.vstack([along[:1], along]), np.vstack([along, along[-1:]])
    cosines = np.einsum("ij,ij->i", before, after)
    if (sharp := int(np.argmin(cosines))) and cosines[sharp] < math.cos(math.radians(TURN_MAX_DEG)):
        turn_deg = math.degrees(math.acos(max(cosines[sharp], -1.0)))
        raise FieldFileError(
            f"polyline: turns by {turn_deg:.0f} deg at point {sharp + 1}: must be at most {TURN_MAX_DEG:g}"
        )
    to_port = (before + after) / (1.0 + cosines)[:, None] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    found: NDArray[np.float64] = line_m + offset_m * to_port
    found[0] -= beyond_m * along[0]
    found[-1] += beyond_m * along[-1]
    return found
