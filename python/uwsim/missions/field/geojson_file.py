"""GeoJSON (RFC 7946): lines and points are routes, polygons areas."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uwsim.missions.field.mission import FieldFileError, FieldMission
from uwsim.missions.field.shapes import SEA, Shapes

GEOMETRIES = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon", "GeometryCollection")
TYPES = ("FeatureCollection", "Feature", *GEOMETRIES)
DEPTH_MAX = 20


def read(document: dict[str, Any]) -> FieldMission:
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
        _add(shapes, name, feature if is_bare else feature.get("geometry"), shapes.properties(given, name))
    return shapes.mission()


def _add(shapes: Shapes, name: str, geometry: Any, has: Mapping[str, float], depth: int = 0) -> None:
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
            _add(shapes, name, each, has, depth + 1)
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
