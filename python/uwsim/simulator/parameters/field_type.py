"""The type, unit and range of a field in a scenario's models, derived from its annotation."""

from __future__ import annotations

import types
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
