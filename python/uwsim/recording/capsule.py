"""Packs a scenario and all the files that it names into a recording's attachments, and unpacks them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic_core import from_json

from uwsim.base.atomic_file import write_atomically
from uwsim.scenario import Scenario
from uwsim.scenario.dump import plain
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.validated import validated

SCENARIO = "scenario.json"
FILE = "$file"
NAME = re.compile(r"files/\d+/[^/\0]*[^/\0.][^/\0]*")
"""The permitted names of files in a recording, which cannot lead outside the folder."""


def pack(scenario: Scenario) -> dict[str, bytes]:
    """Return the content of each attachment, keyed by name: SCENARIO, and the files that it names. Raises OSError."""
    values = plain(scenario)
    names = {path: f"files/{k}/{path.name}" for k, path in enumerate(sorted(set(_paths(values))))}
    files = {name: path.read_bytes() for path, name in names.items()}
    return {SCENARIO: json.dumps(_without_paths(values, names)).encode(), **files}


def unpack(contents: Mapping[str, bytes], folder: Path) -> Scenario:
    """Return the scenario from a result of `pack`.

    Files that still exist unchanged at their original paths are used there, so that textures next to meshes are found.
    Other files are written to the folder. Raises ValueError or OSError.
    """
    if SCENARIO not in contents:
        raise ValueError(f"the recording holds no {SCENARIO}")
    return validated(Scenario, _with_files(from_json(contents[SCENARIO]), contents, folder))


def fingerprint(scenario: Scenario) -> str:
    """Return a digest that is the same for equal scenarios, including their files."""
    return scenario_fingerprint(scenario)


def _paths(value: Any) -> list[Path]:
    if isinstance(value, Path):
        return [value]
    items = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [path for item in items for path in _paths(item)]


def _without_paths(value: Any, names: Mapping[Path, str]) -> Any:
    if isinstance(value, Path):
        return {FILE: names[value], "path": str(value)}
    if isinstance(value, dict):
        return {key: _without_paths(item, names) for key, item in value.items()}
    return [_without_paths(item, names) for item in value] if isinstance(value, list) else value


def _with_files(value: Any, contents: Mapping[str, bytes], folder: Path) -> Any:
    if isinstance(value, dict):
        if FILE in value:
            name, original = value[FILE], value.get("path")
            if not (isinstance(name, str) and NAME.fullmatch(name) and name in contents and isinstance(original, str)):
                raise ValueError(f"the recording's scenario names a file '{name!s:.80}', which it does not hold")
            return _file(contents[name], Path(original), folder / name)
        return {key: _with_files(item, contents, folder) for key, item in value.items()}
    return [_with_files(item, contents, folder) for item in value] if isinstance(value, list) else value


def _file(content: bytes, original: Path, copy: Path) -> Path:
    for path in (original, copy):
        if path.is_file() and path.read_bytes() == content:
            return path
    copy.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(copy, content, flushes=False)
    return copy
