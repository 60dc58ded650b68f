"""Application of a run's values to a scenario, as parameters or as keys in the scenario file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from uwsim.base.named import did_you_mean
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.spec.fields import Model
from uwsim.simulator.parameters import Parameters
from uwsim.simulator.parameters.edits import edited
from uwsim.simulator.parameters.tree import Place, find

PART = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


def varied(scenario: Scenario, values: Mapping[str, Any]) -> Scenario:
    """Return a validated copy with these named values. Raises ScenarioError, naming the offending values."""
    parameters = {name: value for name, value in values.items() if is_parameter(scenario, name)}
    keys = {name: value for name, value in values.items() if name not in parameters}
    changed = scenario
    if keys:
        changed = edited(scenario, {place(scenario, name): value for name, value in keys.items()})
    if parameters:
        held = Parameters(changed, lambda _: None, lambda *_, **__: None, {})
        held.update(parameters)
        changed = held.scenario
    return changed.read_from(scenario.source_file)


def is_parameter(scenario: Scenario, name: str) -> bool:
    """Return whether a name refers to a parameter or a group of parameters."""
    return find(scenario, name) is not None


def place(scenario: Scenario, name: str) -> Place:
    """Parse the name of a scenario key, such as survey.area_m[0][1]. Raises ScenarioError if it is unknown."""
    parts: list[str | int] = [int(index) if index else key for key, index in PART.findall(name)]
    node: Any = scenario
    for k, part in enumerate(parts):
        if not _has(node, part) and not (node is None and k):
            raise _unknown(scenario, name)
        node = _below(node, part)
    if not parts or _written(parts) != name:
        raise _unknown(scenario, name)
    return tuple(parts)


def _unknown(scenario: Scenario, name: str) -> ScenarioError:
    known = [*Parameters(scenario, lambda _: None, lambda *_, **__: None, {}), *_keys(scenario, "")]
    rule = f"neither a parameter of scenario '{scenario.name}' nor a key of its file"
    return ScenarioError(f"{name}: {rule}{did_you_mean(name, known)}")


def _has(node: Any, part: str | int) -> bool:
    if isinstance(node, Model):
        return part in type(node).model_fields
    if isinstance(node, Mapping):
        return isinstance(part, str)
    return isinstance(node, tuple | list) and isinstance(part, int) and part < len(node)


def _below(node: Any, part: str | int) -> Any:
    if isinstance(node, Model):
        return getattr(node, str(part))
    if isinstance(node, Mapping):
        return node.get(str(part))
    return node[part] if isinstance(node, tuple | list) and isinstance(part, int) else None


def _keys(node: Any, above: str) -> Iterator[str]:
    if isinstance(node, Model):
        for key in type(node).model_fields:
            name = f"{above}.{key}" if above else key
            yield name
            yield from _keys(getattr(node, key), name)
    elif isinstance(node, tuple | list) and len(node) <= 64:
        for k, item in enumerate(node):
            yield f"{above}[{k}]"
            yield from _keys(item, f"{above}[{k}]")


def _written(parts: list[str | int]) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts).removeprefix(".")
