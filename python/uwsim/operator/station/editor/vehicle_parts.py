"""The parts of a vehicle as they are written: in the scenario, or in the files of the vehicles that it builds on."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.base.texts.yaml_document import Key
from uwsim.scenario.read.assets import shown_name
from uwsim.scenario.read.spec_file import read_yaml, spec_path

BASES_MAX = 6


def raw_parts(values: Mapping[str, Any], place: tuple[Key, ...], folder: Path) -> dict[str, Any]:
    """Return a vehicle's parts by name, as written. place: vehicles, its number, model, and the key of the parts."""
    return _parts(values["vehicles"][place[1]]["model"], str(place[3]), folder, BASES_MAX)


def is_inherited(values: Mapping[str, Any], place: tuple[Key, ...]) -> bool:
    """Return whether a part of a vehicle is written in another file than the scenario's."""
    if place[0] != "vehicles" or len(place) < 5:
        return False
    model = values["vehicles"][place[1]]["model"]
    own = model.get(place[3]) if isinstance(model, Mapping) else None
    return not isinstance(own, Mapping) or place[4] not in own


def _parts(model: Any, key: str, folder: Path, bases: int) -> dict[str, Any]:
    if isinstance(model, str) and bases > 0:
        path = spec_path(model, "vehicles", folder)
        return _parts(read_yaml(path, shown_name(path)).values, key, path.resolve().parent, bases - 1)
    if not isinstance(model, Mapping):
        return {}
    own = model.get(key) or {}
    if isinstance(own, str):
        path = spec_path(own, "sensors", folder)
        return dict(read_yaml(path, shown_name(path)).values.get("sensors") or {})
    base = _parts(model["builds_on"], key, folder, bases) if "builds_on" in model else {}
    return {name: part for name, part in {**base, **own}.items() if part is not None}
