"""Values that are written into a scene's files: those with which a part begins, and those that a form gives."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate
from pathlib import PurePath
from typing import Any

from uwsim.base.texts.yaml_document import yaml_document
from uwsim.channels.guest import Values
from uwsim.operator.station.editor.forms import SECTIONS, forms, unflattened
from uwsim.operator.station.editor.yaml_change import flow

TEXT_MAX = 4000
DEPTH_MAX = 20
"""Brackets within brackets in a value: the parser's time rises with their square, to 7 s for TEXT_MAX of them."""


def start_values(section: str, kind: str, at_m: tuple[float, float], own: Mapping[str, Any] | None = None) -> Values:
    """Return the values of a new part at a place (x, y), which a person then changes.

    They are the schema's examples, or guesses. own: those that are already known. Raises ValueError if a file is
    missing among them.
    """
    found: Values = {SECTIONS[section].key: kind} if kind else {}
    if inner := SECTIONS[section].inner:
        found = {inner: start_values("obstacles", kind, at_m)}
    under_water = [*at_m, -1.0]
    if section == "vehicles":
        found["start"] = {"position_m": under_water}
    for field in forms()[section][kind]:
        name, width = field["name"], field["width"]
        if field["start"] is not None and "." not in name:
            found[name] = field["start"]
        if name in found or not (field["is_required"] or name == "position_m") or name == "name" or "." in name:
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
        elif field["type"] == "file" and not (own or {}).get(name):
            raise ValueError(f"{name}: must be named first: a packaged file, or one below the scenario's folder")
        else:
            found[name] = field["choices"][0] if field["choices"] else ""
    return found


def _guess(low: float | None, high: float | None) -> float:
    """Return a number to start with: 0, or where that is too small, 1."""
    return 0.0 if low is None or low <= 0.0 else min(max(1.0, low), high or 1.0)


def alone(model: Mapping[str, Values], values: Mapping[str, Any]) -> Values:
    """Return values, with None for the fields that must not stand beside one of them. model: fields by name."""
    given = [model[key] for key, value in values.items() if value is not None and key in model]
    return {**{other: None for field in given for other in field["one_of"]}, **values}


def given(field: Mapping[str, Any], value: Any) -> Any:
    """Return a value from a form as it is written into the file. Raises ValueError."""
    if field["type"] == "yaml" and isinstance(value, str):
        if len(value) > TEXT_MAX:
            raise ValueError(f"{field['name']}: has {len(value)} characters: at most {TEXT_MAX}")
        if _depth(value) > DEPTH_MAX:
            raise ValueError(f"{field['name']}: is nested more than {DEPTH_MAX} deep")
        value = yaml_document(f"value: {value}", field["name"]).values.get("value")
        if len(flow(value)) > TEXT_MAX:
            raise ValueError(f"{field['name']}: its aliases written out, must have at most {TEXT_MAX} characters")
    _require_near(field["name"], value)
    return unflattened(dict(field), value) if field["columns"] else value


def _depth(text: str) -> int:
    """Return how deeply brackets are nested in a text."""
    steps = ((each in "[{") - (each in "]}") for each in text)
    return max(accumulate(steps, lambda depth, step: max(depth + step, 0), initial=0))


def _require_near(name: str, value: Any) -> None:
    """Raise ValueError for a file elsewhere, since the page's user may not be allowed to read this machine's files."""
    if isinstance(value, str):
        path = PurePath(value)
        if path.is_absolute() or ".." in path.parts or value.startswith("~"):
            raise ValueError(f"{name} = {value[:80]!r}: must be a packaged file, or one below the scenario's folder")
    for item in value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ():
        _require_near(name, item)
