"""Writes a scenario as plain values, as a YAML file that reads back as an equal one, or as a file for editing.

Only values that were set explicitly are written, since setting a key, even to its default value, may matter: gains of
an axis without actuators are rejected (`control.sway`), as is a density together with `water.profile`, and each value
of `sonar.noise` overrides the model's.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import mark
from uwsim.scenario.read.assets import YAML_SUFFIXES, assets_folder, find_yaml
from uwsim.scenario.schema import schema_file
from uwsim.scenario.spec.fields import NAME, Model
from uwsim.scenario.spec.scenario import Scenario

PLAIN = frozenset((str, float, int, bool, type(None)))


def plain(value: Any) -> Any:
    """Convert a model, or part of one, to dicts, lists, text, numbers, booleans, None and paths."""
    if type(value) in PLAIN:
        return value
    if isinstance(value, Model):
        return plain(value.given())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def text_values(model: Model) -> dict[str, Any]:
    """Return a model as plain values in which paths are text, as JSON and YAML hold them."""
    found: dict[str, Any] = _with_text_for_paths(plain(model))
    return found


def write_scenario(path: Path, scenario: Scenario) -> None:
    """Write a scenario as a single YAML file, self-contained except for meshes and rasters. Raises OSError."""
    write_model(path, scenario)


def write_model(path: Path, model: Model) -> None:
    """Write a scenario, a vehicle or another part of one as a YAML file. Raises OSError."""
    write_atomically(path, yaml_text(plain(model)).encode())


def yaml_text(values: Any) -> str:
    """Return plain values, in which paths become text, as YAML."""
    from ruamel.yaml import YAML  # here, since it is slow to import

    text = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None  # lists of numbers on one line
    yaml.width = 120
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.dump(_with_text_for_paths(values), text)
    return text.getvalue()


def _with_text_for_paths(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _with_text_for_paths(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_with_text_for_paths(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def new_scenario(name: str, out: Path | None = None, like: str | None = None, overwrite: bool = False) -> Path:
    """Write NAME.yaml into the working folder, or to `out`, and return its path.

    like: a packaged scenario to use as a starting point, instead of the template. The first line of the file refers to
    the schema, so that editors can complete and check keys. Raises ValueError for a bad name, FileExistsError, and
    ScenarioError for an unknown `like`.
    """
    if not NAME.fullmatch(name):
        raise ValueError(f"name '{name}': must be a letter followed by at most 39 letters, digits, '-' or '_'")
    path = Path(f"{name}.yaml") if out is None else out
    if path.suffix not in YAML_SUFFIXES:
        raise ValueError(f"--out {path}: must end in {' or '.join(YAML_SUFFIXES)}")
    source = assets_folder() / "templates" / "scenario.yaml" if like is None else find_yaml(like, "scenarios")
    text = source.read_text(encoding="utf-8")
    if like is None:
        text = text.replace("@NAME@", name).replace("@FILE@", str(path))
    else:
        text = re.sub(r"^name:.*$", f"name: {name}", text, count=1, flags=re.MULTILINE)
    content = f"# yaml-language-server: $schema={schema_file('scenario').as_uri()}\n{text}".encode()
    if overwrite:
        write_atomically(path, content, replaces_any=True)
    else:
        with path.open("xb") as file:
            file.write(content)
        mark(path)
    return path
