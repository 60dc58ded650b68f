"""KML 2.2 (OGC 07-147r2): lines and points are routes, polygons areas."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element

from uwsim.base.texts.xml_text import xml_root
from uwsim.missions.field.mission import FieldFileError, FieldMission
from uwsim.missions.field.shapes import BED, SEA, Shapes

LEFT_OUT = ("NetworkLink", "GroundOverlay", "PhotoOverlay", "ScreenOverlay", "Tour", "Track", "MultiTrack", "Model")
ON_GROUND = ("clampToGround", "clampToSeaFloor")
FRAMES = {"absolute": SEA, "relativeToGround": BED, "relativeToSeaFloor": BED}
"""MAV_FRAME by altitudeMode. Of what is clamped to the ground, the altitude is ignored, as the standard has it."""


def read(text: str, name: str) -> FieldMission:
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
            _add(shapes, title, node, has)
    return shapes.mission()


def _add(shapes: Shapes, name: str, node: Element, has: Mapping[str, float]) -> None:
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
