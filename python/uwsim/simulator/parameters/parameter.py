"""Parameter: the name, value, type, unit, range and description of a scenario parameter, and types from annotations."""

from __future__ import annotations

import types
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from uwsim.scenario.spec.fields import InRange, OneOf

Type = Literal["number", "whole number", "flag", "choice", "text", "list", "structure"]


@dataclass(frozen=True)
class FieldType:
    """The type of a leaf field; see Parameter for the meaning of the attributes."""

    type: Type
    unit: str = ""
    low: float | None = None
    high: float | None = None
    choices: tuple[Any, ...] = ()
    optional: bool = False
    meaning: str = ""


def stripped(annotation: Any, value: Any) -> tuple[Any, list[Any], bool]:
    """Return the member of a union annotation that fits a value, its metadata, and whether None is allowed."""
    metadata: list[Any] = []
    optional = False
    while True:
        if get_origin(annotation) is Annotated:
            annotation, *more = get_args(annotation)
            metadata += more
        elif get_origin(annotation) in (Union, types.UnionType):
            arms = get_args(annotation)
            optional |= type(None) in arms
            annotation = _arm_of([arm for arm in arms if arm is not type(None)], value)
        else:
            return annotation, metadata, optional


def _arm_of(arms: list[Any], value: Any) -> Any:
    for arm in arms:
        kind = stripped(arm, value)[0]
        kind = get_origin(kind) or kind
        if isinstance(kind, type) and isinstance(value, kind):
            return arm
    return arms[0]


def field_type(annotation: Any, metadata: list[Any], optional: bool) -> FieldType:
    """Return the type of a leaf from the result of `stripped`."""
    for rule in metadata:
        if isinstance(rule, InRange):
            kind: Type = "whole number" if annotation is int else "number"
            return FieldType(kind, rule.unit, rule.low, rule.high, optional=optional)
        if isinstance(rule, OneOf):
            return FieldType("choice", choices=tuple(rule.names), optional=optional)
    if annotation is bool:
        return FieldType("flag", optional=optional)
    if get_origin(annotation) is Literal:
        return FieldType("choice", choices=get_args(annotation), optional=optional)
    if get_origin(annotation) is tuple:
        return FieldType("list", optional=optional)
    if annotation is str:
        return FieldType("text", optional=optional)
    return FieldType("structure", optional=optional)


@dataclass(frozen=True)
class Parameter:
    """A parameter, as returned by `describe`.

    name: such as "rov.drag.linear.surge". key: its key in the scenario. value: current value; default: the scenario's
    value. low, high: limits in `unit`, None if unlimited. choices: permitted values of a "choice". optional: whether
    None is also permitted.
    """

    name: str
    key: str
    type: Type
    value: Any
    default: Any
    unit: str = ""
    low: float | None = None
    high: float | None = None
    choices: tuple[Any, ...] = ()
    optional: bool = False
    description: str = ""

    @property
    def range_text(self) -> str:
        """The range or the choices as text."""
        if self.choices:
            return ", ".join(map(str, self.choices))
        if self.type == "flag":
            return "true, false"
        text = "" if self.low is None else f"[{self.low:.12g}, {self.high:.12g}]"
        return f"{text} or none" if text and self.optional else text


def plain(value: Any) -> Any:
    """Convert a value to JSON types: tuples become lists, models dicts."""
    if hasattr(value, "model_dump"):
        return plain({key: getattr(value, key) for key in type(value).model_fields})
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return value.tolist()
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
