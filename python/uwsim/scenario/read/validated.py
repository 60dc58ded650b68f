"""Validation of values against a model, with all mistakes reported together.

pydantic stops at a model's first broken rule and skips rules that combine several fields. Offending values are
therefore left out, or read under the intended key, and the rest is checked again until no new mistake is found.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import BaseModel, ValidationError

from uwsim.base.texts.yaml_document import Key, YamlDocument
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.remainder import Remainder
from uwsim.scenario.read.validation_errors import HINTS, Hints, Mistake, mistakes_in

M = TypeVar("M", bound=BaseModel)

MAX_MISTAKES = 20
MAX_ROUNDS = 50
BASE = "builds_on"
"""The key of the file from which a file takes the values that it does not give."""
LINE_OF_FILE = re.compile(r"(?<=: )\S[^:]*\.ya?ml:\d+: .*", re.DOTALL)
"""The mistake of another file, at the end of a line that states where that file is named."""
MEANT = re.compile(r"did you mean '([^']+)'")


def validated(model: type[M], values: Any, document: YamlDocument | None = None, folder: Path | None = None) -> M:
    """Return a model with these values. folder: where to look for files first. Raises ScenarioError."""
    try:
        return model.model_validate(values, context={"folder": folder or Path(), HINTS: {}})
    except ValidationError:
        raise ScenarioError.of(what_holds(model, values, document, folder).mistakes) from None


@dataclass(frozen=True)
class Holding(Generic[M]):
    """The result of a check. mistakes: the errors found, in file order.

    model: built from the remaining valid parts, or None if too little is valid. left: the remaining valid parts.
    """

    mistakes: list[str]
    model: M | None
    left: Remainder


def what_holds(
    model: type[M], values: Any, document: YamlDocument | None = None, folder: Path | None = None
) -> Holding[M]:
    """Return all mistakes, one line each: at most MAX_MISTAKES, followed by the number of further mistakes."""
    left = Remainder(values)
    found: dict[str, tuple[bool, int, str]] = {}  # a dict, since each absent item of a list repeats the error
    made: M | None = None
    for _ in range(MAX_ROUNDS):
        hints: Hints = {}
        try:
            made = model.model_validate(left.values, context={"folder": folder or Path(), HINTS: hints})
            break
        except ValidationError as error:
            told = mistakes_in(error.errors(include_url=False), hints, left.values, document, left.in_file)
        for mistake in told:
            if not _follows(mistake, left):
                for line, text in mistake.lines:
                    key = LINE_OF_FILE.search(text)  # a file that is named twice has its mistakes once
                    found.setdefault(key[0] if key else text, ("unknown key" not in text, line, text))
        if not _leave_out(told, left):
            break
    mistakes = [text for *_, text in sorted(found.values(), key=lambda each: each[:2])]
    more = len(mistakes) - MAX_MISTAKES
    return Holding([*mistakes[:MAX_MISTAKES], f"{more} more mistakes"] if more > 0 else mistakes, made, left)


def _follows(mistake: Mistake, left: Remainder) -> bool:
    """Return whether a mistake exists only because a value was left out earlier."""
    path, model, gone = left.in_file(mistake.path), left.in_file(mistake.model), left.left_out
    if any(path[:length] in gone.places for length in range(1, len(path) + 1)):
        return True
    for base in (path, path[:-1]):  # the base might have given it
        if (*base, BASE) in gone.places and (base == path or not left.has(mistake.path)):
            return True
    words = {*re.findall(r"\w+", mistake.rule), *re.findall(r"[\w-]+", mistake.rule)}
    if any((model, word) in gone.below for word in words):
        return True
    return path in gone.around and mistake.rule.startswith("must have at least")


def _leave_out(mistakes: list[Mistake], left: Remainder) -> bool:
    """Rename misspelt keys or, failing that, leave out offending values or, failing that, incomplete mappings.

    Only one of these is done at a time, so that as much as possible is checked. Return False if nothing is left to do.
    """
    ordered = sorted(mistakes, key=lambda each: _last_first(each.path), reverse=True)  # last items first
    renamed = [each for each in ordered if (key := _meant(each)) is not None and left.rename(each.path, key)]
    if renamed:
        return True
    is_absent = [each.rule.startswith("missing") and not left.has(each.path) for each in ordered]
    absent = [each for each, lacks in zip(ordered, is_absent, strict=True) if lacks]
    present = [each.path for each, lacks in zip(ordered, is_absent, strict=True) if not lacks]
    gone: set[tuple[Key, ...]] = set()
    for path in present or [each.path[:-1] for each in absent]:
        if any(path[:length] in gone for length in range(1, len(path) + 1)):
            continue
        if (removed := left.leave_out(path)) is not None:
            gone.add(removed)
    return bool(gone)


def _meant(mistake: Mistake) -> str | None:
    meant = MEANT.search(mistake.rule) if mistake.rule.startswith("unknown key") else None
    return meant and meant[1]


def _last_first(path: tuple[Key, ...]) -> tuple[tuple[bool, int, str], ...]:
    return tuple((True, key, "") if isinstance(key, int) else (False, 0, key) for key in path)
