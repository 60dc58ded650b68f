"""The values with which a new part of a scene begins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uwsim.channels.guest import Values
from uwsim.operator.station.editor.forms import SECTIONS, forms, unflattened
from uwsim.scenario.spec.camera import Lamps
from uwsim.scenario.spec.obstacle import OBSTACLES

EXAMPLES: Mapping[str, Mapping[str, Any]] = {
    "lamps": Lamps.example,
    "props": {"model": "drum"},
    "objects": {"density_kg_m3": 1100},
    "vehicles": {"model": "bluerov2_heavy_outfit"},
    "terrain noise": {"size_m": [100, 100], "spacing_m": 1, "bed_depth_m": 10, "hill_height_m": 3},
    "terrain image": {
        "file": "terrains/mountains.png", "size_m": [200, 200], "spacing_m": 1, "black_m": -20, "white_m": -5,
    },
    "terrain raster": {
        "file": "terrains/jacksboro_srtm.asc", "crs": "EPSG:4326", "water_level_m": 550, "horizontal_scale": 0.05,
        "vertical_scale": 0.11, "centre": [-84.19, 36.6], "size_m": [440, 320], "spacing_m": 1,
    },
    "strokes": {"width_m": 10, "height_m": 2},
    "tide": {"constituents": [{"constituent": "M2", "amplitude_m": 1}]},
    "surface airy": {"amplitude_m": 0.3, "period_s": 6},
    "surface jonswap": {"significant_height_m": 0.5, "peak_period_s": 6},
    "wind": {"speed_m_s": 5},
    "cover": {"density_per_m2": 0.3, "size_m": [0.2, 0.5]},
    "cover kelp": {"density_per_m2": 0.3, "size_m": [2, 4]},
    "life": {"count": 20, "size_m": [0.2, 0.3]},
    "exercise": {"title": "New exercise", "brief": "Meet the goals in their order.", "pass_points": 10},
    "goals move_joint": {"to_deg": 90},
    "layout": {"x_m": [-0.5, 0.5], "y_m": [-0.5, 0.5]},
    "limits depth": {"most_m": 10},
    "limits altitude": {"least_m": 0.5},
    "limits speed": {"most_m_s": 1},
    "events": {
        "at_s": 30, "command": "inject_fault", "arguments": {"kind": "current", "velocity_world_m_s": [0.2, 0, 0]},
    },
}  # fmt: skip
"""Values with which a new part begins, by section and kind, or by section."""


def start_values(section: str, kind: str, at_m: tuple[float, float]) -> Values:
    """Return the values of a new part at a place (x, y), which a person then changes."""
    if inner := SECTIONS[section].inner:
        return {inner: start_values("obstacles", kind, at_m), **EXAMPLES[section]}
    found: Values = {SECTIONS[section].key: kind} if kind else {}
    usual = EXAMPLES.get(f"{section} {kind}") or EXAMPLES.get(section, {})
    found |= OBSTACLES.models()[kind].example if section == "obstacles" else usual
    under_water = [*at_m, -1.0]
    if section == "vehicles":
        found["start"] = {"position_m": under_water}
    for field in forms()[section][kind]:
        name, width = field["name"], field["width"]
        if name in found or not (field["is_required"] or name == "position_m") or name == "name":
            continue
        number = _guess(field["low"], field["high"])
        if field["role"] == "place":
            found[name] = under_water if section in ("life", "goals", "exercise_start") else [*at_m, 0.0][:width]
        elif field["role"] == "line" and field["columns"][:2] == ["x", "y"]:
            corners = ((0.0, 0.0),) if section == "strokes" else ((-5.0, -5.0), (5.0, -5.0), (5.0, 5.0))
            z = under_water[2:] if "z" in field["columns"] else []
            found[name] = [[round(at_m[0] + dx, 3), round(at_m[1] + dy, 3), *z] for dx, dy in corners]
        elif field["columns"]:
            found[name] = unflattened(field, [[0.0] * len(field["columns"])])
        elif field["type"] == "number":
            found[name] = number if width == 1 else [number] * width
        else:
            found[name] = field["choices"][0] if field["choices"] else ""
    return found


def _guess(low: float | None, high: float | None) -> float:
    """Return a number to start with: 0, or where that is too small, 1."""
    return 0.0 if low is None or low <= 0.0 else min(max(1.0, low), high or 1.0)
