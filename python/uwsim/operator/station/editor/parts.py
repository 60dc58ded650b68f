"""The parts of an edited scene, as the page shows them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from uwsim.channels.guest import Values
from uwsim.operator.station.editor.draft import Draft
from uwsim.operator.station.editor.files import Place, is_inherited
from uwsim.operator.station.editor.forms import SECTIONS
from uwsim.operator.station.editor.goal_values import choices
from uwsim.scenario import Scenario, start_pose


def parts(draft: Draft) -> Iterator[Values]:
    """Yield the scenario's parts; see wire.editor.EditedPart."""
    values, scenario = draft.values, draft.scenario
    for section, found in SECTIONS.items():
        for vehicle in range(len(scenario.vehicles) if found.of_vehicle else 1):
            above = found.below(vehicle)
            for place, name in _places(draft, section, above, values):
                own = draft.shown(section, place)
                is_docked = section == "starts" and not own
                outline = draft.plan.outlines_m[int(place[1])] if section == "obstacles" else []
                if is_docked:
                    position_m, yaw_rad = start_pose(scenario, scenario.vehicles[vehicle])
                    own = {"position_m": list(position_m), "yaw_deg": math.degrees(yaw_rad)}
                yield {
                    "section": section, "place": list(place), "name": str(own.get(found.field("name"), name)),
                    "kind": str(own.get(found.field(found.key), "")), "vehicle": vehicle if found.of_vehicle else None,
                    "is_inherited": is_docked or is_inherited(values, place),
                    "frame": _frame(scenario, section, vehicle, own), "values": own, "outline_m": outline,
                    "choices": choices(scenario, draft.goals, own) if section in ("goals", "events", "layout") else {},
                }  # fmt: skip


def _places(draft: Draft, section: str, above: Place, values: Any) -> Iterator[tuple[Place, str]]:
    """Yield the places of a section's parts, and names for those that have none of their own."""
    holds = SECTIONS[section].holds
    if holds == "names":
        yield from (((*above, name), name) for name in draft.names(above))
        return
    for key in above:
        values = values.get(key) if isinstance(values, dict) else values[int(key)]
        if values is None:
            break
    if section == "starts":
        yield above, draft.scenario.vehicles[int(above[1])].name
    elif (holds == "one" and values is not None) or isinstance(values, dict):
        yield above, section
    else:
        yield from (((*above, k), f"{section} {k + 1}") for k in range(len(values or ())))


def _frame(scenario: Scenario, section: str, vehicle: int, own: Values) -> list[float]:
    """Return the place and direction, x, y [m], yaw [deg], z [m], of the frame in which a part's position is given."""
    if section == "goals":
        for prop in scenario.placed_props:
            if prop.name == own.get("of"):
                return [*prop.position_m[:2], prop.yaw_deg, prop.position_m[2]]
    if section == "starts" or not SECTIONS[section].of_vehicle:
        return [0.0, 0.0, 0.0, 0.0]
    (x, y, z), yaw_rad = start_pose(scenario, scenario.vehicles[vehicle])
    return [x, y, math.degrees(yaw_rad), z]
