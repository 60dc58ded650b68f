"""The scenario of a command, as a word or by --scenario: each command that takes one takes both spellings."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from typer.core import TyperArgument, TyperOption

from uwsim.cli.bounds import UsageError

NAME, OPTION = "scenario", "--scenario"
YAML = (".yaml", ".yml")


class _Word(str):
    """A word of the command line, which is found again among others of the same letters."""


def with_both_spellings(command: Any) -> Any:
    """Return a typer command, or a group of some, that takes its scenario in both spellings, if it takes one.

    A command with an option takes the last of its words, if that has no other place, or is a scenario by its name or
    suffix. The other spelling is among the command's parameters for --help and completion only: the words are always
    parsed with one of the two.
    """
    for each in dict(getattr(command, "commands", {})).values():
        with_both_spellings(each)
    own = next((each for each in command.params if each.name == NAME), None)
    if own is None:
        return command
    settings = {"type_descriptor": own.type_descriptor, "callback": own.callback}
    words, by_word = list(command.params), None
    if own.param_type_name == "option":
        shown: Any = TyperArgument(param_decls=[NAME], help=f"The same as {OPTION}.", **settings)
        by_option = words
    else:
        settings |= {"param_decls": [OPTION], "help": "The same as the word."}
        shown = TyperOption(**settings)
        by_word = words
        meant = TyperOption(default=own.default, required=own.required, **settings)
        by_option = [meant if each is own else each for each in words]
    shown.shell_complete = own.shell_complete
    command.params = [*words, shown]
    command.format_help = partial(_with_parameters, command, command.params, command.format_help)
    command.parse_args = partial(_parsed, command, command.parse_args, by_option, by_word)
    return command


def _with_parameters(command: Any, parameters: list[Any], act: Callable[..., Any], *given: Any) -> Any:
    """Do something with other parameters of a command."""
    before, command.params = command.params, parameters
    try:
        return act(*given)
    finally:
        command.params = before


def _parsed(
    command: Any, parse: Any, by_option: list[Any], by_word: list[Any] | None, ctx: Any, args: list[str]
) -> Any:
    """Parse the words of a command. by_word: its parameters if the scenario is one of its arguments."""
    words = [_Word(each) for each in args]
    read = lambda: command.make_parser(ctx).parse_args(list(words))  # noqa: E731
    found, beyond, _ = _with_parameters(command, by_option, read)
    if isinstance(found.get(NAME), str):
        if beyond and not ctx.resilient_parsing:
            raise UsageError(f"{OPTION} {found[NAME]}, {beyond[0]}: one too many: give the scenario once")
    elif by_word is not None:
        return _with_parameters(command, by_word, parse, ctx, args)
    else:
        places = [each for each in by_option if each.param_type_name == "argument"]
        given = [word for each in places for word in _words(found.get(each.name))]
        last = given[-1] if len(given) > sum(each.required for each in places) and _is_scenario(given[-1]) else None
        if (word := next(iter(beyond), last)) is not None:
            args = [OPTION, str(word), *(str(each) for each in words if each is not word)]
    return _with_parameters(command, by_option, parse, ctx, args)


def _words(value: Any) -> list[_Word]:
    several = value if isinstance(value, tuple | list) else [value]
    return [each for each in several if isinstance(each, _Word)]


def _is_scenario(word: str) -> bool:
    from uwsim.scenario.read.assets import packaged_names

    return word.endswith(YAML) or word in packaged_names("scenarios")
