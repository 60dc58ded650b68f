"""The parts of a JSON Schema that pydantic cannot derive: descriptions, units, ranges, and kinds from core tables.

Descriptions are parsed from docstrings with `key, other_key [unit]: words.` for each field. Uses draft 7, which all
editors support.
"""

from __future__ import annotations

import functools
import inspect
import math
import re
from collections.abc import Mapping
from typing import Any, Protocol

from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaValue

KEY = r"[a-z][a-z0-9_]*(?: \[[^\]]*\])?"
KEYS = re.compile(rf"(?:^|(?<=[.;:] )|(?<=\n))({KEY}(?:,\s{KEY})*):\s")


EVERYWHERE = {
    "kind": "the kind; each kind has its own keys",
    "name": "a letter followed by at most 39 letters, digits, '-' or '_'",
    "description": "a one-line description",
    "yaw_pitch_roll_deg": "rotations about z, then the new y, then the new x",
    "material": "a material's name, or its kind and the values that differ",
}
"""Default descriptions of fields that most models share."""


@functools.cache
def descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Return the descriptions of a model's fields by name, from its own docstring or that of a base class."""
    found = {key: words for key, words in EVERYWHERE.items() if key in model.model_fields}
    for base in reversed(model.__mro__):
        if issubclass(base, BaseModel):
            found |= _described_in(base, frozenset(model.model_fields))
    return found


def _described_in(model: type[BaseModel], fields: frozenset[str]) -> dict[str, str]:
    """Return the descriptions of these fields in a model's docstring; inherited fields may belong to another model."""
    text = inspect.getdoc(model) or ""
    found: dict[str, str] = {}
    starts = [match for match in KEYS.finditer(text) if _fields(match[1]) & fields]
    for k, match in enumerate(starts):
        end = starts[k + 1].start() if k + 1 < len(starts) else len(text)
        words = " ".join(text[match.end() : end].split())
        found |= dict.fromkeys(_fields(match[1]), words)
    matrices = {key + "_matrix": words for key, words in found.items() if key + "_matrix" in fields}
    return matrices | found


def summary(model: type[BaseModel]) -> str:
    """Return the description of the model itself: the part of the docstring before the first field."""
    text = inspect.getdoc(model) or ""
    for match in KEYS.finditer(text):
        if _fields(match[1]) & set(model.model_fields):
            return " ".join(text[: match.start()].split())
    return " ".join(text.split())


def _fields(keys: str) -> set[str]:
    return {key.partition(" ")[0] for key in re.split(r",\s", keys)}


class SensorFigure(Protocol):
    """A key of one kind of sensor; see _core.Parameter."""

    @property
    def width(self) -> int:
        """The number of values."""

    @property
    def by_default(self) -> float:
        """The default of each value; NaN if the key is required."""

    @property
    def low(self) -> float:
        """The smallest value."""

    @property
    def high(self) -> float:
        """The largest value."""

    @property
    def unit(self) -> str:
        """The unit."""

    @property
    def type(self) -> str:
        """One of "number", "whole number" and "flag"."""

    @property
    def meaning(self) -> str:
        """A description."""


UNIT = "x-unit"
"""Keyword for a number's unit; validators ignore unknown keywords."""
ONE_OF = "x-one-of"
"""Keyword for the names of fields that must not stand beside each other."""


def in_range(kind: str, low: float, high: float, unit: str = "") -> JsonSchemaValue:
    """Return the schema of a number or integer in [low, high]."""
    schema: JsonSchemaValue = {"type": kind}
    if 0.0 < low < 1e-300:
        schema["exclusiveMinimum"] = 0
    elif math.isfinite(low):
        schema["minimum"] = _whole(low)
    if math.isfinite(high):
        schema["maximum"] = _whole(high)
    return schema | ({UNIT: unit} if unit else {})


def described(model: type[BaseModel], schema: JsonSchemaValue) -> None:
    """Add descriptions from a model's docstring, with ranges and units, to its schema and properties."""
    schema["description"] = summary(model)
    words = descriptions(model)
    for name, part in schema.get("properties", {}).items():
        part.pop("title", None)
        if part.get("default") is None or isinstance(part["default"], dict):  # stated elsewhere
            part.pop("default", None)
        if text := "; ".join(filter(None, (words.get(name, "").rstrip(".;"), _range(part)))):
            part["description"] = text[:1].upper() + text[1:]


def one_of_kinds(schema: JsonSchemaValue, kinds: Mapping[str, JsonSchemaValue], without: set[str]) -> None:
    """Turn a model's schema into a choice of kinds, each with its own properties in addition to the shared ones."""
    shared = {key: value for key, value in schema["properties"].items() if key not in {"kind", *without}}
    required = [key for key in schema.get("required", []) if key not in without]
    options = [
        {
            "type": "object",
            "description": own.get("description", ""),
            "properties": {"kind": {"const": kind}, **shared, **own["properties"]},
            "required": [*required, *own.get("required", [])],
            "additionalProperties": False,
        }
        for kind, own in kinds.items()
    ]
    for key in ("properties", "required", "additionalProperties", "type"):
        schema.pop(key, None)
    schema["oneOf"] = options


def figures(parameters: Mapping[str, SensorFigure], in_degrees: bool = False) -> JsonSchemaValue:
    """Return a schema's properties for the parameters of a kind of sensor or imaging sonar, and which are required.

    in_degrees: whether angles are in degrees, under names that end in _deg.
    """
    properties, required = {}, []
    for name, parameter in parameters.items():
        turned = in_degrees and name.endswith("_rad")
        key = name.removesuffix("_rad") + "_deg" if turned else name
        properties[key] = _figure(parameter, turned)
        if math.isnan(parameter.by_default):
            required.append(key)
        elif parameter.width == 1:
            by_default = math.degrees(parameter.by_default) if turned else parameter.by_default
            properties[key]["default"] = bool(by_default) if parameter.type == "flag" else _whole(round(by_default, 9))
    return {"properties": properties, "required": required}


def _figure(parameter: SensorFigure, turned: bool) -> JsonSchemaValue:
    if parameter.type == "flag":
        return {"type": "boolean", "description": parameter.meaning}
    low, high = parameter.low, parameter.high
    low, high = (math.degrees(low), math.degrees(high)) if turned else (low, high)
    kind = "integer" if parameter.type == "whole number" else "number"
    schema = in_range(kind, low, high, "deg" if turned else parameter.unit)
    if parameter.width > 1:
        schema = {"type": "array", "items": schema, "minItems": parameter.width, "maxItems": parameter.width}
    return schema | {"description": "; ".join(filter(None, (parameter.meaning, _range(schema))))}


def _range(part: JsonSchemaValue) -> str:
    """Return `0 to 5 m` for a number or a list of numbers, and an empty string for anything else."""
    if "maximum" in part:
        least = part.get("minimum", part.get("exclusiveMinimum"))
        return f"{_short(least)} to {_short(part['maximum'])} {part.get(UNIT, '')}".strip() if least is not None else ""
    for inner in (part.get("items"), *part.get("anyOf", [])):
        if isinstance(inner, dict) and (text := _range(inner)):
            return text
    return str(part.get(UNIT, ""))


def _short(value: float) -> str:
    return f"{value:.12g}" if float(value).is_integer() else f"{value:.4g}"


def _whole(value: float) -> Any:
    """Return whole floats as integers, so that 1e+06 is written as 1000000 and 5.0 as 5."""
    return int(value) if float(value).is_integer() and abs(value) < 2**63 else value
