"""Shapes of charts: routes, points and areas with their names and properties, made into a mission."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

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
