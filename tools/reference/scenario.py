"""The scenario reference: every key of every model that a scenario's YAML file may contain."""

import inspect
import types
from pathlib import Path
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BeforeValidator
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined
from tools.reference.markdown import code, plain, table

from uwsim.scenario.spec.fields import InRange, Model
from uwsim.scenario.spec.json_schema import descriptions
from uwsim.scenario.spec.kinds import Kinds
from uwsim.scenario.spec.scenario import Scenario
from uwsim.simulator.parameters.parameter import field_type, stripped

HEAD = """# Scenario files

This page lists every key of a scenario's YAML file. It is generated from the models that check such files.
`uwsim scenario check FILE` checks a file, and [scenarios](../guides/scenarios.md) shows examples. Keys without a
default are required.

"""


def scenario_page() -> str:
    """Return the page, with a section for each model."""
    return HEAD + "\n".join(section(model) for model in reachable(Scenario))


def reachable(root: type[Model]) -> list[type[Model]]:
    """Return the models that a scenario may contain, each once, in the order of their first mention."""
    found: list[type[Model]] = []

    def visit(model: type[Model]) -> None:
        if model not in found:
            found.append(model)
            for info in model.model_fields.values():
                for part in _models_in(_annotation(info)):
                    visit(part)

    visit(root)
    return found


def _models_in(annotation: Any) -> list[type[Model]]:
    if isinstance(annotation, type) and issubclass(annotation, Model):
        return [annotation]
    for rule in get_args(annotation):
        if isinstance(rule, Kinds):
            return list(rule.models(own=True).values())
    return [model for part in get_args(annotation) for model in _models_in(part)]


def section(model: type[Model]) -> str:
    """Return a model's section: a table of its keys."""
    words = descriptions(model)
    rows = [_row(name, info, words.get(name, "")) for name, info in model.model_fields.items()]
    summary = (inspect.getdoc(model) or "").split("\n\n")[0]
    return f"({_anchor(model)})=\n## {model.__name__}\n\n{plain(summary)}\n\n" + table(
        ("key", "type", "default", "meaning"), rows
    )


def _row(name: str, info: FieldInfo, words: str) -> tuple[str, str, str, str]:
    return code(name), _kind(_annotation(info)), _default(info), plain(words)


def _annotation(info: FieldInfo) -> Any:
    """Return a field's type with its rules: of a field that may be written in another form, that of what is written."""
    written = [rule.json_schema_input_type for rule in info.metadata if isinstance(rule, BeforeValidator)]
    if info.annotation is not Path and written and written[0] is not PydanticUndefined:
        return written[0]
    return Annotated[info.annotation, *info.metadata] if info.metadata else info.annotation


def _kind(annotation: Any) -> str:
    annotation, metadata, optional = _arms(annotation)
    parts = [_one_kind(arm, metadata) for arm in annotation]
    text = " or ".join(dict.fromkeys(parts))
    return f"{text}, or null" if optional else text


def _arms(annotation: Any) -> tuple[list[Any], list[Any], bool]:
    metadata: list[Any] = []
    while get_origin(annotation) is Annotated:
        annotation, *more = get_args(annotation)
        metadata += more
    for rule in metadata:
        if isinstance(rule, Kinds):
            return list(rule.models(own=True).values()), metadata, False
    if get_origin(annotation) in (Union, types.UnionType):
        arms = get_args(annotation)
        found = [each for arm in arms if arm is not type(None) for each in _kinds_of(arm)]
        return found, metadata, type(None) in arms
    return [annotation], metadata, False


def _kinds_of(arm: Any) -> list[Any]:
    """Return the models of a union's arm that is a spec of one of several kinds, or else the arm."""
    rules = get_args(arm)[1:] if get_origin(arm) is Annotated else ()
    return next((list(rule.models(own=True).values()) for rule in rules if isinstance(rule, Kinds)), [arm])


def _one_kind(annotation: Any, metadata: list[Any]) -> str:
    annotation, more, _ = stripped(annotation, None)
    found = field_type(annotation, [*metadata, *more], optional=False)
    ranges = [rule for rule in (*metadata, *more) if isinstance(rule, InRange)]
    if ranges:
        return f"{found.type} in {ranges[0].low:g} ... {ranges[0].high:g} {plain(ranges[0].unit)}".strip()
    if found.choices:
        return "one of " + ", ".join(code(str(choice)) for choice in found.choices)
    if models := _models_in(annotation):
        links = ", ".join(f"[{model.__name__}](#{_anchor(model)})" for model in dict.fromkeys(models))
        origin = get_origin(annotation)
        return f"list of {links}" if origin is tuple else f"by name: {links}" if origin is dict else links
    if get_origin(annotation) is tuple:
        parts = [_kind(part) for part in get_args(annotation) if part is not Ellipsis]
        return f"list: {', '.join(parts)}" if len(set(parts)) > 1 else f"list of {parts[0]}"
    if get_origin(annotation) is dict:
        return f"by name: {_kind(get_args(annotation)[1])}"
    return found.type if found.type != "structure" else getattr(annotation, "__name__", "anything")


def _default(info: FieldInfo) -> str:
    if info.is_required():
        return "must be given"
    value = info.get_default(call_default_factory=not _needs_data(info))
    if value is PydanticUndefined or isinstance(value, Model):
        return "its defaults"
    if value in (None, (), {}, ""):
        return "none"
    text = str(value)
    return code(text) if len(text) < 60 else "see the file"


def _needs_data(info: FieldInfo) -> bool:
    return bool(info.default_factory_takes_validated_data)


def _anchor(model: type[Model]) -> str:
    return f"scenario-{model.__name__.lower()}"
