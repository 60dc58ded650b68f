"""The tree of a scenario's parameters: their names, paths in the scenario's models, and values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, get_args

from uwsim.base.axes import AXES
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.imaging_sonar import ImagingMount
from uwsim.scenario.spec.json_schema import descriptions
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.sensor import Noise, SensorMount
from uwsim.simulator.parameters import table
from uwsim.simulator.parameters.effective import effective, idle, imaging_figures, noise_unit, sensor_figures
from uwsim.simulator.parameters.parameter import FieldType, field_type, stripped

Place = tuple[str | int, ...]
"""The path to a value through a scenario's models: fields, keys and indices."""


def joined(above: str, name: str) -> str:
    """Join the names of a parent and a child with a dot; either may be empty."""
    return f"{above}.{name}" if above and name else above or name


@dataclass(frozen=True)
class Node:
    """A node of the tree. type: None for a group. idle: the reason why the value currently has no effect, or ""."""

    name: str
    place: Place
    value: Any
    type: FieldType | None = None
    description: str = ""
    idle: str = ""

    @property
    def key(self) -> str:
        """The path in the notation of messages about a scenario: vehicles[0].model.mass_kg."""
        text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in self.place)
        return text.removeprefix(".")

    def below(self, name: str, part: str | int, value: Any) -> Node:
        """Return the node for a child. name: "" if the names of its own children directly follow this node's name."""
        return Node(joined(self.name, name), (*self.place, part), value, None, self.description, self.idle)


def nodes(scenario: Scenario, towards: str = "") -> dict[str, Node]:
    """Return all leaves and groups by name. towards: if not empty, only those above, at and below this name."""
    found: dict[str, Node] = {}
    for node in _Walk(scenario, towards).model(Node("", (), scenario)):
        if node.name:
            found.setdefault(node.name, node)
    return _with_groups(found)


def _with_groups(found: dict[str, Node]) -> dict[str, Node]:
    """Add groups that exist only in names, such as rov.drag, the parent of drag.linear and drag.quadratic."""
    groups: dict[str, dict[str, Any]] = {}
    for name, node in found.items():
        above, _, last = name.rpartition(".")
        if above and above not in found:
            groups.setdefault(above, {})[last] = node.value
    return found | {name: Node(name, (), parts) for name, parts in groups.items()}


def find(scenario: Scenario, name: object) -> Node | None:
    """Return the node with this name, or None, with much less work than `nodes`."""
    return nodes(scenario, name).get(name) if isinstance(name, str) else None


@cache
def _fields(owner: type[Model]) -> list[tuple[str, str, Any, list[Any], str]]:
    """Return field, name, annotation, rules and description of each model field that is a parameter."""
    words = descriptions(owner) | {"kind": "another kind needs its own keys, given together: set all of it at once"}
    return [
        (field, table.NAMES.get((owner, field), field), info.annotation, info.metadata, words.get(field, ""))
        for field, info in owner.model_fields.items()
        if field not in table.FIXED.get(owner, ())
    ]


@dataclass(frozen=True)
class _Walk:
    scenario: Scenario
    towards: str

    def leads_on(self, name: str) -> bool:
        """Return whether a name is above, at or below the name being sought."""
        sought = self.towards
        return (
            not sought or not name or name == sought or sought.startswith(name + ".") or name.startswith(sought + ".")
        )

    def model(self, at: Node) -> Iterator[Node]:
        """Yield the nodes below a model."""
        model = at.value
        if isinstance(model, SensorMount):
            yield from self._sensor_figures(at)
        if isinstance(model, ImagingMount):
            for key, (kind, value) in imaging_figures(model).items():
                yield replace(at.below(key, key, value), type=kind, description=kind.meaning)
        owner: type[Model] = type(model)
        for field, name, annotation, rules, words in _fields(owner):
            if table.is_absent(model, field) or not self.leads_on(joined(at.name, name)):
                continue
            value = effective(model, field, self.scenario)
            node = at.below(name, field, value)
            node = Node(node.name, node.place, value, None, words, at.idle or idle(model, field))
            inner, metadata, optional = stripped(annotation, value)
            yield from self._value(node, (inner, [*metadata, *rules], optional), owner)

    def _value(self, at: Node, kind: tuple[Any, list[Any], bool], owner: type[Model]) -> Iterator[Node]:
        value = at.value
        if not self.leads_on(at.name):
            return
        if isinstance(value, Model):
            yield at
            yield from self.model(at)
        elif isinstance(value, Mapping):
            yield at
            for key, item in value.items():
                yield from self._value(at.below(key, key, item), (type(item), [], False), owner)
        elif isinstance(value, tuple) and value:
            yield at
            yield from self._items(at, kind[0], owner)
        else:
            yield replace(at, type=self._leaf_type(at, kind, owner))

    def _items(self, at: Node, annotation: Any, owner: type[Model]) -> Iterator[Node]:
        field, value = str(at.place[-1]), at.value
        if field.endswith("_matrix"):
            yield from _matrix(at)
            return
        kinds = get_args(annotation)
        kinds = kinds[:1] * len(value) if kinds[-1:] == (Ellipsis,) else kinds
        names = table.item_names(owner, field, len(value))
        if at.place == ("vehicles",):
            names = tuple(vehicle.name for vehicle in value)
        for k, (item, kind) in enumerate(zip(value, kinds, strict=True)):
            yield from self._value(at.below(names[k], k, item), stripped(kind, item), owner)

    def _leaf_type(self, at: Node, kind: tuple[Any, list[Any], bool], owner: type[Model]) -> FieldType:
        found = field_type(*kind)
        if at.place[-1] == "kind":
            return replace(found, choices=table.KINDS[owner])
        if owner is Noise:
            return replace(found, unit=noise_unit(self.scenario, at.place) or found.unit)
        return found

    def _sensor_figures(self, at: Node) -> Iterator[Node]:
        for key, (kind, values) in sensor_figures(at.value).items():
            node = replace(at.below(key, key, values), description=kind.meaning)
            if len(values) == 1:
                yield replace(node, value=bool(values[0]) if kind.type == "flag" else values[0], type=kind)
                continue
            yield node
            for k, item in enumerate(table.item_names(SensorMount, key, len(values))):
                yield replace(node.below(item, k, values[k]), type=kind)


def _matrix(at: Node) -> Iterator[Node]:
    """Yield the diagonal elements, named after their axis ("surge"), and the others, named after both ("surge_yaw")."""
    for i, row in enumerate(at.value):
        for j, value in enumerate(row):
            name = AXES[i] if i == j else f"{AXES[i]}_{AXES[j]}"
            kind = FieldType("number", "SI", -1e6, 1e6)
            yield replace(at.below(name, i, value), place=(*at.place, i, j), type=kind)
