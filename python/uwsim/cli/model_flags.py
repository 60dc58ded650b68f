"""Flags from the fields of a pydantic model, so that a command states nothing that the model states already."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import Any, ClassVar

from uwsim.base.options import Flag, FlagGroup, is_given

KINDS = {"integer": int, "number": float}


class ModelFlags(FlagGroup):
    """The values of a model's fields, those that are given; the model also accepts what is not a number as text.

    model: its module and name, such as `package.module:Name`; it is imported when the command is used. others: fields
    that are no flags. A field that is a mapping is a flag NAME=VALUES, which may be repeated.
    """

    model: ClassVar[str]
    others: ClassVar[tuple[str, ...]] = ()

    def __init__(self, **values: Any) -> None:
        self.arguments = {name: value for name, value in values.items() if is_given(value)}

    @classmethod
    @cache
    def flags(cls) -> Mapping[str, Flag]:
        """Return the flags by field."""
        module, _, name = cls.model.partition(":")
        properties = getattr(import_module(module), name).model_json_schema()["properties"]
        return {name: _flag(part) for name, part in properties.items() if name not in cls.others}


def _flag(part: Mapping[str, Any]) -> Flag:
    inner = next(each for each in part.get("anyOf", [part]) if each.get("type") != "null")
    kind = KINDS.get(inner.get("type"), str)
    words = part["description"] + "."
    if (default := part.get("default")) not in (None, []):
        words += f" Default: {','.join(default) if isinstance(default, list) else default}."
    if inner.get("type") == "object":
        return Flag(tuple[str, ...], (), words, metavar="NAME=VALUES")
    bounds = None if kind is str else (inner["minimum"], inner["maximum"], inner.get("x-unit", ""))
    return Flag(kind | None, None, words, tuple(inner.get("enum", ())), bounds)
