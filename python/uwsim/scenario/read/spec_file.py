"""Reads the parts of a scenario that have their own YAML files: vehicles, thrusters, sonars and sensor sets."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel

from uwsim.scenario.read.assets import find_yaml, shown_name
from uwsim.scenario.read.source_file import SourceFile
from uwsim.scenario.read.validated import validated
from uwsim.scenario.read.yaml_file import read_yaml

Spec = TypeVar("Spec", bound=BaseModel)


def read_spec(model: type[Spec], source: str | Path, kind: str, folder: Path | None = None) -> Spec:
    """Read and validate the YAML file of a packaged name or a path. Raises ScenarioError.

    kind: the assets folder in which packaged names are found, such as "vehicles". folder: the base of relative paths,
    by default the working folder.
    """
    path = spec_path(source, kind, folder)
    document = read_yaml(path, shown_name(path))
    spec = validated(model, document.values, document, folder=path.resolve().parent)
    if "_source_file" in spec.__private_attributes__:
        spec._source_file = SourceFile(document)  # type: ignore[attr-defined]
    return spec


def spec_path(source: str | Path, kind: str, folder: Path | None = None) -> Path:
    """Return the YAML file that read_spec reads. Raises ScenarioError if there is none."""
    beside = (folder or Path()) / source
    return beside if beside.is_file() else find_yaml(source, kind)
