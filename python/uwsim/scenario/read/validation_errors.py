"""Converts pydantic's validation errors to one line each: place, value, unit, rule.

`lake.yaml:12: vehicles[0].sonr: unknown key; did you mean 'sonar'?` `lake.yaml:7: water.density_kg_m3 = 5000 kg/m3:
must be in [900, 1100] kg/m3`
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from uwsim.base.named import did_you_mean
from uwsim.base.texts.yaml_document import Key, YamlDocument, dotted
from uwsim.scenario.read.errors import ScenarioError

TAGS = ("source", "kind")
"""Keys that select one of several models; pydantic includes their values in error locations."""

HINTS = "hints"
"""Key of the Hints in the validation context."""

HINTS_MAX = 200
"""The most unknown keys for which a similar one is sought, which takes longer than everything else."""

Hints = dict[str, str]
"""The end of the message for each unknown key, which suggests the most similar known key."""

InFile = Callable[[Sequence[Key]], Sequence[Key]]

Place = tuple[Key, ...]

RULES = {
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be text",
    "tuple_type": "must be a list",
    "model_type": "must be keys and values",
    "model_attributes_type": "must be keys and values",
    "too_short": "must have at least {min_length} items",
    "too_long": "must have at most {max_length} items",
}


class Mistake(NamedTuple):
    """A pydantic error. path: key path of the error. model: key path of the model whose rule is broken.

    lines: pairs of line number and text; several if the error lies in another file with several mistakes.
    """

    path: tuple[Key, ...]
    model: tuple[Key, ...]
    rule: str
    lines: tuple[tuple[int, str], ...]


def mistakes_in(
    errors: Sequence[ErrorDetails], hints: Hints, values: Any, document: YamlDocument | None, in_file: InFile
) -> list[Mistake]:
    """Return the errors that are not consequences of others. in_file: converts positions in `values` to the file's."""
    beside = _Beside.of(errors)
    return [
        _described(error, beside, hints, values, document, in_file)
        for error in errors
        if not _follows_from_another(error, beside, hints)
    ]


class _Beside(NamedTuple):
    """The errors by the place of the value that contains theirs: with the names of keys, or their number.

    around: the places that contain an error.
    """

    unknown: dict[Place, list[str]]
    wrong: dict[Place, set[str]]
    missing: Counter[Place]
    around: set[Place]

    @classmethod
    def of(cls, errors: Sequence[ErrorDetails]) -> _Beside:
        found = cls(defaultdict(list), defaultdict(set), Counter(), set())
        for error in errors:
            loc = error["loc"]
            found.missing[loc[:-1]] += error["type"] == "missing"
            if not loc:
                continue
            if error["type"] == "extra_forbidden":
                found.unknown[loc[:-1]].append(str(loc[-1]))
            else:
                found.wrong[loc[:-1]].add(str(loc[-1]))
            found.around.update(loc[:length] for length in range(len(loc)))
        return found


def _described(
    error: ErrorDetails,
    beside: _Beside,
    hints: Hints,
    values: Any,
    document: YamlDocument | None,
    in_file: InFile,
) -> Mistake:
    below, shown, rules = _explained(error, beside, hints)
    model = _path(values, error["loc"])
    path = [*model, *below]
    if error["type"] == "missing" and isinstance(path[-1], int):  # report the list instead of its absent item
        path.pop()
    found = in_file(path)
    place, line = dotted(found), document.line(found) if document else 0
    where = f"{document.name}:{line}: " if document else ""
    what = " ".join(part for part in (place, shown) if part) + (": " if place else "")
    return Mistake(tuple(path), tuple(model), rules[0], tuple((line, where + what + rule) for rule in rules))


def _follows_from_another(error: ErrorDetails, beside: _Beside, hints: Hints) -> bool:
    """Return whether an error is only a consequence of another, which is reported instead."""
    kind, loc = error["type"], error["loc"]
    if kind == "default_factory_not_called":  # another field is invalid
        return True
    if kind == "missing":  # its key is misspelt
        unknown = beside.unknown.get(loc[:-1], ())[:HINTS_MAX]  # others have no hints
        return any(f"'{loc[-1]}'" in hints.get(key, "") for key in unknown)
    if kind == "extra_forbidden":  # the kind to which this key belongs is unknown or misspelt
        wrong = beside.wrong.get(loc[:-1], ())
        return any(tag in wrong and f"'{tag}'" not in hints.get(str(loc[-1]), "") for tag in TAGS)
    return kind == "too_short" and loc in beside.around  # invalid items do not count


def _explained(error: ErrorDetails, beside: _Beside, hints: Hints) -> tuple[Sequence[Key], str, Sequence[str]]:
    """Return the keys below the error's location, `= value unit` and the rule, or the mistakes of another file."""
    if isinstance(error.get("ctx", {}).get("error"), ScenarioError):  # from a file named in this one
        return (), "", error["ctx"]["error"].mistakes
    if error["type"] == "extra_forbidden":
        return (), "", ["unknown key" + hints.get(str(error["loc"][-1]), "")]
    below, shown, rule = _rule(error, beside)
    return below, shown, [rule]


def _rule(error: ErrorDetails, beside: _Beside) -> tuple[Sequence[Key], str, str]:
    kind, value, context = error["type"], error["input"], error.get("ctx", {})
    if kind == "rule":
        has_value = "value" in context or not context["at"]
        shown = _shown(context.get("value", value), context.get("unit", "")) if has_value else ""
        return context["at"], shown, context["rule"]
    if kind == "missing" and isinstance(error["loc"][-1], str):
        return (), "", "missing"
    if kind == "missing":
        return (), _shown(value), f"must have {len(value) + beside.missing[error['loc'][:-1]]} values"
    if kind.startswith("union_tag"):
        tag = (str(context["discriminator"]).strip("'"),)
        if kind == "union_tag_not_found":
            return tag, "", "missing"
        known = str(context["expected_tags"])
        hint = did_you_mean(str(context["tag"]), [name.strip(" '") for name in known.split(",")])
        return tag, f"= '{context['tag']}'", f"must be one of {known}{hint}"
    if kind == "literal_error":
        expected = context["expected"].replace("True", "true")  # as YAML writes it
        return (), _shown(value), f"must be {expected}"
    if kind == "tuple_type" and isinstance(value, dict):
        return (), "", "must be a list, of items that begin with '- '"
    rule = RULES.get(kind, error["msg"][:1].lower() + error["msg"][1:]).format(**context)
    return (), _shown(value), rule


def _path(values: Any, loc: Sequence[Key]) -> list[Key]:
    """Return the key path of an error in the file: pydantic's location without union tags."""
    path: list[Key] = []
    node, entered = values, True
    for part in loc:
        if str(part).startswith("["):  # pydantic's marker for a dict's key, and markers of our own unions
            continue
        if isinstance(part, int) and isinstance(node, dict):  # a single item written without its list
            continue
        if entered and isinstance(node, dict) and part in [node.get(tag) for tag in TAGS]:
            entered = False
            continue
        path.append(part)
        try:
            node = node[part]
        except (KeyError, IndexError, TypeError):
            node = None
        entered = True
    return path


def _shown(value: Any, unit: str = "") -> str:
    if value is None or isinstance(value, dict | BaseModel):
        return ""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, float):
        text = f"{value:.12g}"
    elif isinstance(value, int) and value.bit_length() > 1000:  # Python refuses to print more than about 4000 digits
        text = f"a number of about {value.bit_length() * 0.30103:.0f} digits"
    else:
        text = f"'{value}'" if isinstance(value, str | Path) else str(value)
    text = text if len(text) <= 60 else text[:57] + "..."
    return f"= {text} {unit}".rstrip()
