"""The YAML files of scenarios, whose content is cached: parsing takes a tenth of a simulator's start-up time."""

from __future__ import annotations

import copy
import functools
from pathlib import Path
from typing import Any

from uwsim.base.texts import yaml_document
from uwsim.base.texts.yaml_document import YamlDocument
from uwsim.scenario.read.disk_cache import cached_json
from uwsim.scenario.read.errors import ScenarioError


def read_yaml(path: Path, name: str) -> YamlDocument:
    """Read a YAML mapping. name: the file's name, for messages. Raises ScenarioError with name and line."""
    try:
        return yaml_document.read_yaml(path, name, lambda text, name: copy.deepcopy(_values(text, name)))
    except ValueError as error:
        raise ScenarioError(str(error)) from None


@functools.lru_cache(maxsize=64)  # files rarely change
def _values(text: str, name: str) -> dict[str, Any]:
    """Return a document's content, which must not be modified."""

    def parse() -> dict[str, Any]:
        from uwsim.base.texts.yaml_parser import plain_values

        return plain_values(text, name)

    values: dict[str, Any] = cached_json(parse, "yaml", text)
    return values
