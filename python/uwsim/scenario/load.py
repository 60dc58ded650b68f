"""Loads and validates a scenario by name or path, or from a dictionary."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.base.no_collections import no_collections
from uwsim.scenario.read.assets import assets_folder, find_yaml, packaged_names
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.spec_file import SourceFile, read_yaml
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.scenario import Scenario

AnyScenario = str | Path | Scenario | Mapping[str, Any]
"""A packaged name, the path of a YAML file, a Scenario, or such a file's content: the doors of Python take each."""


def load(source: AnyScenario) -> Scenario:
    """Return a scenario from a packaged name ("lake"), the path of a YAML file, such a file's content, or a Scenario.

    Files named in it are looked up relative to it, or to the working folder, then among the packaged assets; vehicle
    files are also read. Raises ScenarioError, with one line per mistake that states file, line, key, value, unit and
    rule.
    """
    if isinstance(source, Scenario):
        return source
    if not isinstance(source, str | Path | Mapping):
        raise ScenarioError(f"scenario: expected a name, a path, a dict or a Scenario, not {type(source).__name__}")
    if not Scenario.__pydantic_complete__:  # its validator is built when first needed
        with no_collections():
            Scenario.model_rebuild()
    if isinstance(source, Mapping):
        return validated(Scenario, dict(source), folder=Path.cwd())
    path = find_yaml(source, "scenarios")
    is_packaged = assets_folder() in path.parents
    document = read_yaml(path, path.name if is_packaged else str(source))
    scenario = validated(Scenario, document.values, document, folder=path.resolve().parent)
    return scenario.read_from(SourceFile(document))


def packaged_scenarios() -> list[str]:
    """Return the names that `load` accepts without a path."""
    return packaged_names("scenarios")
