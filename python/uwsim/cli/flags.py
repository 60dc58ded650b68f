"""Flags of commands from classes of options and from pydantic models, so that no command states them again."""

from __future__ import annotations

import functools
import inspect
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, ClassVar, get_args, get_origin, get_type_hints

import typer

from uwsim.base.options import Flag, FlagGroup, flag_name, is_given
from uwsim.base.sockets import SocketWarning
from uwsim.cli.values import COMPLETED, one_of, readable, within


def expanded(command: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command's function for typer, with a parameter for each flag of its parameters of type FlagGroup.

    Of flags with the same name, the first is kept. Warns with SocketWarning of others, which only a bridge of another
    package can have.
    """
    hints = get_type_hints(command, include_extras=True)
    groups = {name: hint for name, hint in hints.items() if isinstance(hint, type) and issubclass(hint, FlagGroup)}
    if not groups:
        return command
    own = inspect.signature(command).parameters
    found: dict[str, inspect.Parameter] = {}
    of_group: dict[str, list[str]] = {name: [] for name in groups}
    for name, parameter in own.items():
        if name not in groups:
            found[name] = parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=hints[name])
            continue
        for flag, settings in groups[name].flags().items():
            if flag in found or flag in own.keys() - groups.keys():
                warnings.warn(f"{flag_name(flag)}: another option has this name", SocketWarning, stacklevel=2)
                continue
            found[flag] = _parameter(flag, settings)
            of_group[name].append(flag)

    @functools.wraps(command)
    def call(**values: Any) -> Any:
        for name, group in groups.items():
            given = {flag: values.pop(flag) for flag in of_group[name]}
            repeated = [flag for flag in given if _is_repeated(group.flags()[flag])]
            values[name] = group(**given | {flag: tuple(given[flag] or ()) for flag in repeated})
        return command(**values)

    call.__signature__ = inspect.Signature(list(found.values()))  # type: ignore[attr-defined]
    call.__annotations__ = {name: parameter.annotation for name, parameter in found.items()}
    return call


def _parameter(name: str, flag: Flag) -> inspect.Parameter:
    settings: dict[str, Any] = {"help": flag.help, "metavar": flag.metavar}
    if flag.choices:
        settings |= one_of(*flag.choices)
    if flag.bounds is not None:
        settings["callback"] = within(*flag.bounds)
    if Path in get_args(flag.type) and not flag.is_written:
        settings["callback"] = readable
    if flag.completion:
        settings["autocompletion"] = COMPLETED[flag.completion]
    both = f"/--no-{flag_name(name)[2:]}" if bool in get_args(flag.type) else ""  # None: neither was given
    option = typer.Option(flag_name(name) + both, **settings)
    kind, default = (list[str] | None, None) if _is_repeated(flag) else (flag.type, flag.default)
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, option])


def _is_repeated(flag: Flag) -> bool:
    return get_origin(flag.type) is tuple


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
