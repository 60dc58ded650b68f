"""pydantic's validation errors as one line: where, the value, its unit, the rule.

`lake.yaml:12: vehicles[0].sonr: unknown key; did you mean 'sonar'?`
`lake.yaml:7: water.density_kg_m3 = 5000 kg/m3: must be in [900, 1100] kg/m3`
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from uwsim.scenario.read.did_you_mean import did_you_mean
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.yaml_document import Key, YamlDocument

M = TypeVar("M", bound=BaseModel)

TAGS = ("source", "kind")
"""Keys that select one of several models; pydantic adds their values to the locations of errors."""

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


def validated(model: type[M], values: Any, document: YamlDocument | None = None, folder: Path | None = None) -> M:
    """Check values against a model and return it. Relative files are sought in `folder` first. Raises ScenarioError."""
    try:
        return model.model_validate(values, context={"folder": folder or Path()})
    except ValidationError as error:
        raise ScenarioError(one_line(error.errors(include_url=False), values, document)) from None


def one_line(errors: Sequence[ErrorDetails], values: Any, document: YamlDocument | None) -> str:
    """Describe the first error. Unknown keys come first: a misspelt key also makes the right one missing."""
    first = min(errors, key=lambda error: not error["msg"].startswith("unknown key"))
    below, shown, rule = _explained(first, errors)
    path = [*_path(values, first["loc"]), *below]
    if first["type"] == "missing" and isinstance(path[-1], int):  # report the list, not the absent item
        path.pop()
    place = _dotted(path)
    where = f"{document.name}:{document.line(path)}: " if document else ""
    return where + " ".join(part for part in (place, shown) if part) + (": " if place else "") + rule


def _explained(error: ErrorDetails, errors: Sequence[ErrorDetails]) -> tuple[Sequence[Key], str, str]:
    """Return the keys below the error's location, `= value unit`, and the rule."""
    kind, value, context = error["type"], error["input"], error.get("ctx", {})
    if isinstance(context.get("error"), ScenarioError):  # from a file that this one names
        return (), "", str(context["error"])
    if kind == "rule":
        has_value = "value" in context or not context["at"]
        shown = _shown(context.get("value", value), context.get("unit", "")) if has_value else ""
        return context["at"], shown, context["rule"]
    if kind == "missing" and isinstance(error["loc"][-1], str):
        return (), "", "missing"
    if kind == "missing":
        absent = sum(other["type"] == "missing" and other["loc"][:-1] == error["loc"][:-1] for other in errors)
        return (), _shown(value), f"must have {len(value) + absent} values"
    if kind.startswith("union_tag"):
        tag = (str(context["discriminator"]).strip("'"),)
        if kind == "union_tag_not_found":
            return tag, "", "missing"
        known = str(context["expected_tags"])
        hint = did_you_mean(str(context["tag"]), [name.strip(" '") for name in known.split(",")])
        return tag, f"= '{context['tag']}'", f"must be one of {known}{hint}"
    if kind == "literal_error":
        return (), _shown(value), f"must be {context['expected']}"
    rule = RULES.get(kind, error["msg"][:1].lower() + error["msg"][1:]).format(**context)
    return (), _shown(value), rule


def _path(values: Any, loc: Sequence[Key]) -> list[Key]:
    """Return the keys to the error in the file: pydantic's location without the tags of unions."""
    path: list[Key] = []
    node, entered = values, True
    for part in loc:
        if part == "[key]":  # of a dict
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


def _dotted(path: Sequence[Key]) -> str:
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def _shown(value: Any, unit: str = "") -> str:
    if value is None or isinstance(value, dict | BaseModel):
        return ""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, float):
        text = f"{value:.12g}"
    elif isinstance(value, int) and value.bit_length() > 1000:  # Python refuses to print more than some 4000 digits
        text = f"a number of about {value.bit_length() * 0.30103:.0f} digits"
    else:
        text = f"'{value}'" if isinstance(value, str | Path) else str(value)
    text = text if len(text) <= 60 else text[:57] + "..."
    return f"= {text} {unit}".rstrip()
