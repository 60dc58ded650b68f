"""Writes a scenario's survey, or a mission of the field, as a plan that QGroundControl opens."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.flight.flyable_lanes import required_survey, survey_plan
from uwsim.mapping.files.georeference import HOME, Place
from uwsim.missions.fence import Zone
from uwsim.missions.field import Item, is_mission_file, read_mission_file
from uwsim.missions.field.mission import LatLon, waypoint
from uwsim.missions.items import ABOVE_BED, CHANGE_SPEED, KINDS
from uwsim.scenario import load, start_pose
from uwsim.scenario.georeference import georeference

ARDUPILOT, SUBMARINE, NO_POSITION = 3, 12, 2  # MAV_AUTOPILOT, MAV_TYPE, MAV_FRAME


def plan_of(source: str) -> tuple[dict[str, Any], str | None]:
    """Return the plan of a file of the field, or of the lanes of a scenario's survey, and a sentence on its place.

    Lanes are waypoints at the survey's altitude above the bed. Raises ValueError or OSError.
    """
    if is_mission_file(Path(source)):
        mission = read_mission_file(source)
        if not mission.items:
            raise ValueError(f"{source}: has an area and no route: `uwsim survey --area` flies it")
        first = next((item for item in mission.items if item.x or item.y), mission.items[0])
        return _document(mission.items, mission.home or (1e-7 * first.x, 1e-7 * first.y), mission.fence), None
    scenario = load(source)
    survey, found = required_survey(scenario), georeference(scenario)
    place: Place = HOME if found.crs is None else found
    start_m, _ = start_pose(scenario, scenario.vehicles[0])
    items = [Item(1, NO_POSITION, CHANGE_SPEED, 1.0, survey.speed_m_s, -1.0)]
    for lane in survey_plan(survey).lanes_near(np.array(start_m[:2])):
        for end in (lane.start_m, lane.end_m):
            lat, lon = map(float, place.degrees(np.array([*end, 0.0])))
            items.append(waypoint(len(items) + 1, (lat, lon), survey.altitude_m, ABOVE_BED[0]))
    lat, lon = map(float, place.degrees(np.array([*start_m[:2], 0.0])))
    note = None if found.crs is not None else f"scenario '{scenario.name}' is not on Earth: its origin is assumed at "
    return _document(items, (lat, lon)), note and f"{note}latitude {HOME.lat_deg:g}, longitude {HOME.lon_deg:g} deg"


def _document(items: Iterable[Item], home: LatLon, fence: Iterable[Zone] = ()) -> dict[str, Any]:
    mission = {
        "version": 2, "firmwareType": ARDUPILOT, "vehicleType": SUBMARINE, "cruiseSpeed": 1, "hoverSpeed": 1,
        "plannedHomePosition": [*home, 0], "items": [_simple(item) for item in items],
    }  # fmt: skip
    circles = [
        {
            "circle": {"center": [*zone.corners[0]], "radius": zone.radius_m},
            "inclusion": zone.is_inclusion,
            "version": 1,
        }
        for zone in fence
        if zone.radius_m
    ]
    polygons = [
        {"polygon": [[*corner] for corner in zone.corners], "inclusion": zone.is_inclusion, "version": 1}
        for zone in fence
        if not zone.radius_m
    ]
    return {
        "fileType": "Plan", "groundStation": "QGroundControl", "version": 1, "mission": mission,
        "geoFence": {"circles": circles, "polygons": polygons, "version": 2},
        "rallyPoints": {"points": [], "version": 2},
    }  # fmt: skip


def _simple(item: Item) -> dict[str, Any]:
    kind = KINDS.get(item.command)
    scale = 1.0 if item.frame == NO_POSITION else 1e-7
    x, y = (round(scale * value, 7) for value in (item.x, item.y))
    found: dict[str, Any] = {
        "type": "SimpleItem", "autoContinue": True, "command": item.command, "doJumpId": item.seq, "frame": item.frame,
        "params": [item.param1, item.param2, item.param3, item.param4, x, y, item.z],
    }  # fmt: skip
    if kind is not None and kind.is_placed:
        mode = {0: 2, 5: 2, 3: 1, 6: 1}.get(item.frame, 4)
        found |= {"Altitude": item.z, "AltitudeMode": mode, "AMSLAltAboveTerrain": None}
    return found
