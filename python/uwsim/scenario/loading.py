"""From a name or a path to a checked scenario."""

from __future__ import annotations

from pathlib import Path

from uwsim.scenario.document import read_document
from uwsim.scenario.errors import ScenarioError
from uwsim.scenario.messages import validated
from uwsim.scenario.origin import Origin
from uwsim.scenario.paths import assets_folder, find_yaml, packaged_names
from uwsim.scenario.schema import Scenario


def load(source: str | Path | Scenario) -> Scenario:
    """Return a scenario from a packaged name ("lake"), the path of a YAML file, or itself.

    Files that the YAML names are sought relative to it, then among the packaged assets; vehicles are read too.
    Raises ScenarioError, one line that names file, line, key, value, unit and rule.
    """
    if isinstance(source, Scenario):
        return source
    if not isinstance(source, str | Path):
        raise ScenarioError(f"scenario: expected a name, a path or a Scenario, not {type(source).__name__}")
    path = find_yaml(source, "scenarios")
    packaged = assets_folder() in path.parents
    document = read_document(path, path.name if packaged else str(source))
    scenario = validated(Scenario, document.values, document, folder=path.resolve().parent)
    return scenario.read_from(Origin(document))


def packaged_scenarios() -> list[str]:
    """Return the names that `load` knows."""
    return packaged_names("scenarios")
