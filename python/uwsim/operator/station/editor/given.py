"""Values that a form gives, checked before they are written into a scene's files."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate
from pathlib import PurePath
from typing import Any

from uwsim.base.texts.yaml_document import yaml_document
from uwsim.operator.station.editor.forms import unflattened
from uwsim.operator.station.editor.yaml_change import flow

TEXT_MAX = 4000
DEPTH_MAX = 20
"""Brackets within brackets in a value: the parser's time rises with their square, to 7 s for TEXT_MAX of them."""


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
