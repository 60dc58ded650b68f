"""Charts as missions: GeoJSON (RFC 7946) and KML 2.2 (OGC 07-147r2). Lines and points are routes, polygons areas."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.etree.ElementTree import Element

from uwsim.exchange.xml_text import xml_root
from uwsim.missions.field.mission import (
    ITEMS_MAX,
    Area,
    FieldFileError,
    FieldMission,
    Item,
    LatLon,
    lat_lon,
    number,
    ring,
    waypoint,
)
from uwsim.missions.items import ABOVE_BED, HEIGHT_MAX_M

SEA, BED, YAW = 0, ABOVE_BED[0], 115
UNITS = {"altitude": "m", "depth": "m", "heading": "deg", "spacing": "m"}
"""The properties that are honoured, also with their units, as depth_m."""
GEOMETRIES = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon", "GeometryCollection")
TYPES = ("FeatureCollection", "Feature", *GEOMETRIES)
DEPTH_MAX = 20
LEFT_OUT = ("NetworkLink", "GroundOverlay", "PhotoOverlay", "ScreenOverlay", "Tour", "Track", "MultiTrack", "Model")
ON_GROUND = ("clampToGround", "clampToSeaFloor")
FRAMES = {"absolute": SEA, "relativeToGround": BED, "relativeToSeaFloor": BED}
"""MAV_FRAME by altitudeMode. Of what is clamped to the ground, the altitude is ignored, as the standard has it."""


@dataclass
class Shapes:
    """Collects the shapes of a file in its order. Positions have longitude, latitude and perhaps an altitude.

    Points are a route if there is no other.
    """

    items: list[Item] = field(default_factory=list)
    points: list[tuple[str, Sequence[Any], Mapping[str, float], int]] = field(default_factory=list)
    areas: list[Area] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    at_surface: list[str] = field(default_factory=list)

    def properties(self, given: Mapping[str, Any], name: str) -> dict[str, float]:
        """Return the properties that are honoured, without their units, and note the others. Raises FieldFileError."""
        known, others = dict[str, float](), []
        for key, value in given.items():
            word = key.removesuffix("_m").removesuffix("_deg")
            if word not in UNITS or value is None:
                others.append(key)
                continue
            high = {"heading": 360.0, "altitude": HEIGHT_MAX_M}.get(word, 12_000.0)
            low = -360.0 if word == "heading" else 0.0
            known[word] = number(value, f"{name}: {key}", low, high, UNITS[word])
        if others := [key for key in others if key not in ("name", "styleUrl")]:
            shown = ", ".join(sorted(others)[:8])[:120]
            self.notes.append(f"{name}: properties {shown}: left out")
        return known

    def route(self, name: str, positions: Sequence[Any], has: Mapping[str, float], frame: int = SEA) -> None:
        """Add waypoints. frame: of the positions' own altitudes."""
        for k, position in enumerate(positions, 1):
            if not isinstance(position, list | tuple) or not 2 <= len(position) <= 4:
                raise FieldFileError(
                    f"{name}, position {k} = {position!r:.40}: must be [longitude, latitude, altitude]"
                )
            at = lat_lon((position[1], position[0]), f"{name}, position {k}")
            used, z = frame, 0.0
            if "altitude" in has:
                used, z = BED, has["altitude"]
            elif "depth" in has:
                used, z = SEA, -has["depth"]
            elif len(position) > 2:
                z = number(position[2], f"{name}, position {k}: altitude", -1e6, 1e6, "m")
            else:
                self.at_surface.append(name)
            self.items.append(waypoint(len(self.items) + 1, at, z, used))
            if "heading" in has and len(positions) == 1:
                self.items.append(Item(len(self.items) + 1, 2, YAW, has["heading"] % 360))
            if len(self.items) > ITEMS_MAX:
                raise FieldFileError(f"has more than {ITEMS_MAX} positions")

    def area(self, name: str, rings: Sequence[Any], has: Mapping[str, float]) -> None:
        """Add an area by its rings, of which all but the first are holes, which are not left out."""
        if not rings:
            raise FieldFileError(f"{name}: has no ring")
        corners: list[LatLon] = [(0.0, 0.0)] * len(rings[0])
        for k, position in enumerate(rings[0]):
            if not isinstance(position, list | tuple) or len(position) < 2:
                raise FieldFileError(f"{name}, corner {k + 1} = {position!r:.40}: must be [longitude, latitude]")
            corners[k] = (position[1], position[0])
        if len(rings) > 1:
            self.notes.append(f"{name}: {len(rings) - 1} holes: are surveyed as well")
        heading = has.get("heading")
        self.areas.append(
            Area(
                name,
                ring(corners, name),
                None if heading is None else heading % 360,
                has.get("spacing"),
                has.get("altitude"),
            )
        )

    def mission(self) -> FieldMission:
        """Return the mission of all shapes."""
        if self.points and not self.items:
            for name, position, has, frame in self.points:
                self.route(name, [position], has, frame)
        elif self.points:
            names = ", ".join(name for name, *_ in self.points[:5])[:120]
            self.notes.append(f"{len(self.points)} points beside the lines ({names}): left out")
        if surface := list(dict.fromkeys(self.at_surface)):
            names = ", ".join(surface[:5])[:120]
            self.notes.append(f"{names}: no altitude and no depth: flown at the surface, unless altitude_m is given")
        return FieldMission(tuple(self.items), tuple(self.areas), notes=tuple(self.notes))


def read_geojson(document: dict[str, Any]) -> FieldMission:
    """Return the mission. Raises FieldFileError."""
    kind = document["type"]
    if document.get("crs") is not None and "CRS84" not in str(document["crs"]) and "4326" not in str(document["crs"]):
        raise FieldFileError(f"crs = {document['crs']!r:.60}: must be longitude and latitude on WGS 84 (RFC 7946)")
    features = document.get("features") if kind == "FeatureCollection" else [document]
    if not isinstance(features, list):
        raise FieldFileError(f"features = {features!r:.40}: must be a list")
    shapes = Shapes()
    for k, feature in enumerate(features, 1):
        if not isinstance(feature, dict):
            raise FieldFileError(f"feature {k} = {feature!r:.40}: must be an object")
        is_bare = kind not in ("FeatureCollection", "Feature")
        given = {} if is_bare else feature.get("properties") or {}
        if not isinstance(given, dict):
            raise FieldFileError(f"feature {k}: properties = {given!r:.40}: must be an object")
        name = f"feature {k}" + (f" '{given['name']!s:.40}'" if given.get("name") else "")
        _add_geometry(shapes, name, feature if is_bare else feature.get("geometry"), shapes.properties(given, name))
    return shapes.mission()


def _add_geometry(shapes: Shapes, name: str, geometry: Any, has: Mapping[str, float], depth: int = 0) -> None:
    """Add a geometry. Raises FieldFileError."""
    if geometry is None:
        shapes.notes.append(f"{name}: has no geometry: left out")
        return
    kind = geometry.get("type") if isinstance(geometry, dict) else geometry
    if not isinstance(geometry, dict) or kind not in GEOMETRIES or depth > DEPTH_MAX:
        raise FieldFileError(f"{name}: geometry {kind!r:.40}: must be one of {', '.join(GEOMETRIES)}")
    key = "geometries" if kind == "GeometryCollection" else "coordinates"
    content = geometry.get(key)
    if not isinstance(content, list):
        raise FieldFileError(f"{name}: {key} = {content!r:.40}: must be a list")
    if kind == "GeometryCollection":
        for each in content:
            _add_geometry(shapes, name, each, has, depth + 1)
    elif kind == "Point":
        shapes.points.append((name, content, has, SEA))
    elif kind in ("MultiPoint", "LineString"):
        shapes.route(name, content, has)
    elif kind == "Polygon":
        shapes.area(name, _lists(content, name), has)
    else:
        for each in _lists(content, name):
            if kind == "MultiPolygon":
                shapes.area(name, _lists(each, name), has)
            else:
                shapes.route(name, each, has)


def _lists(content: list[Any], name: str) -> list[list[Any]]:
    for each in content:
        if not isinstance(each, list):
            raise FieldFileError(f"{name}: coordinates {each!r:.40}: must be lists of positions")
    return content


def read_kml(text: str, name: str) -> FieldMission:
    """Return the mission. Raises FieldFileError, or ValueError for what is not XML."""
    root = xml_root(text.encode(), name)
    for node in root.iter():
        node.tag = node.tag.rpartition(":")[2]
    if root.tag != "kml":
        raise FieldFileError(f"root '{root.tag:.40}': must be kml")
    shapes = Shapes()
    for tag, count in Counter(node.tag for node in root.iter() if node.tag in LEFT_OUT).items():
        shapes.notes.append(f"{count} {tag}: left out")
    for k, placemark in enumerate(root.iter("Placemark"), 1):
        called = (placemark.findtext("name") or "").strip()
        title = f"placemark {k}" + (f" '{called:.40}'" if called else "")
        given = {data.get("name", ""): (data.findtext("value") or "").strip() for data in placemark.iter("Data")}
        given |= {data.get("name", ""): (data.text or "").strip() for data in placemark.iter("SimpleData")}
        has = shapes.properties({key: value for key, value in given.items() if key}, title)
        for node in placemark.iter():
            _add_node(shapes, title, node, has)
    return shapes.mission()


def _add_node(shapes: Shapes, name: str, node: Element, has: Mapping[str, float]) -> None:
    if node.tag == "Polygon":
        rings = [_positions(ring, name) for ring in node.iter("LinearRing")]
        shapes.area(name, rings, has)
    elif node.tag in ("LineString", "Point"):
        mode = node.findtext("altitudeMode", "clampToGround").strip()
        if mode not in (*FRAMES, *ON_GROUND):
            raise FieldFileError(f"{name}: altitudeMode '{mode:.40}': must be {', '.join((*FRAMES, *ON_GROUND))}")
        positions = _positions(node, name)
        if mode in ON_GROUND:
            positions = [position[:2] for position in positions]
        frame = FRAMES.get(mode, SEA)
        if node.tag == "Point":
            shapes.points += [(name, position, has, frame) for position in positions]
        else:
            shapes.route(name, positions, has, frame)


def _positions(node: Element, name: str) -> list[list[Any]]:
    """Return the positions of an element: longitude, latitude and perhaps an altitude, divided by commas."""
    text = node.findtext("coordinates")
    if text is None or not text.strip():
        raise FieldFileError(f"{name}: {node.tag}: has no coordinates")
    return [[word for word in position.split(",") if word] for position in text.split()]
