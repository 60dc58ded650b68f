"""Descriptions of models and fields, parsed from docstrings with `key, other_key [unit]: words.` for each field."""

from __future__ import annotations

import functools
import inspect
import re

from pydantic import BaseModel

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
