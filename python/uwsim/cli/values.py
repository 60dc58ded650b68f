"""Values on the command line: checks before a command starts, fixed sets of words, and the shell's completion."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperArgument, TyperOption

from uwsim.base.options import OptionError, require_one_of, require_within


class UsageError(typer.BadParameter):
    """An invalid command line; typer exits with the same code as for an unknown option."""

    def format_message(self) -> str:
        """Return the message unchanged."""
        return str(self.message)


def within(low: float, high: float, unit: str = "") -> Callable[..., Any]:
    """Return a typer callback for options that take numbers in [low, high]; nan is refused."""

    def check(param: typer.CallbackParam, value: Any) -> Any:
        for number in value if isinstance(value, tuple) else (value,):
            try:
                require_within(option_name(param), number, low, high, unit)
            except OptionError as error:
                raise UsageError(str(error)) from None
        return value

    check.bounds = low, high, unit  # type: ignore[attr-defined]  # read by code that lists options with bounds
    return check


def readable(param: typer.CallbackParam, value: Any) -> Any:
    """Return paths if they may be read; a typer callback.

    Raises UsageError for devices and pipes, which may be endless.
    """
    for path in value if isinstance(value, list) else (value,):
        if isinstance(path, Path):
            require_file(path, option_name(param))
    return value


def writable(param: typer.CallbackParam, value: Path | None) -> Path | None:
    """Return a path if it can be written; a typer callback, which reports an error before a long computation."""
    if value is not None:
        require_file(value, option_name(param))
        if value.is_dir():
            raise UsageError(f"{option_name(param)} = '{value}': is a folder: must be a file")
        if not os.access(value.parent, os.W_OK):
            raise UsageError(f"{option_name(param)} = '{value}': cannot write into the folder '{value.parent}'")
    return value


def require_file(path: Path, name: str) -> None:
    """Raise UsageError for a device or a pipe. name: the option, for the message."""
    try:
        kind = path.stat().st_mode
    except (OSError, ValueError):  # such as a name that is too long; opening it will raise the error
        return
    if not stat.S_ISREG(kind) and not stat.S_ISDIR(kind):
        what = "a device" if stat.S_ISCHR(kind) or stat.S_ISBLK(kind) else "a pipe or a socket"
        raise UsageError(f"{name} = '{path}': is {what}: must be a file")


def refusal(error: Any) -> str:
    """Return the message of a usage error of typer. One about a number states its value, range and unit."""
    param: Any = getattr(error, "param", None)
    found = getattr(error.__cause__, "errors", None)
    bounds = getattr(getattr(param, "callback", None), "bounds", None)
    if bounds is None or not callable(found):
        return str(error.format_message()).rstrip(".")
    low, high, unit = bounds
    kind = "whole number" if str(found()[0]["type"]).startswith("int") else "number"
    rule = f"must be a {kind} in [{low:.12g}, {high:.12g}] {unit}".rstrip()
    return f"{option_name(param)} = '{str(found()[0]['input'])[:40]}': {rule}"


def option_name(param: typer.CallbackParam) -> str:
    """Return a parameter's name as users type it, such as --voxel or MAP."""
    return str(param.opts[-1]) if param.opts and param.opts[-1].startswith("-") else str(param.name).upper()


Completer = Callable[[str], list[str]]
"""A completion function for typer: maps the beginning of a word to its possible completions."""


def packaged_folder(name: str, in_sources: str) -> Path:
    """Return a folder of the installed package, or of the source tree."""
    package = Path(__file__).resolve().parents[1]
    return next(folder for folder in (package / name, package.parents[1] / in_sources) if folder.is_dir())


def words(*known: str) -> Completer:
    """Return the completion function for these words."""

    def complete(incomplete: str) -> list[str]:
        return [word for word in known if word.startswith(incomplete)]

    return complete


def packaged(kind: str, *others: str) -> Completer:
    """Return the completion function for packaged files, further words, and YAML files in the current folder.

    It lists folders itself, since `uwsim.scenario` is slow to import.
    """

    def complete(incomplete: str) -> list[str]:
        names = sorted(path.stem for path in (packaged_folder("assets", "assets") / kind).glob("*.yaml"))
        here = sorted(path.name for path in Path().glob("*.y*ml"))
        return words(*others, *names, *here)(incomplete)

    return complete


scenarios = packaged("scenarios")
exercises = packaged("exercises")
vehicle_models = packaged("vehicles")
sonars = packaged("sonars", "1", "2", "3", "4")
modems = packaged("modems")
vehicles = packaged("vehicles")
sequences = packaged("sequences")
COMPLETED = {
    "scenarios": scenarios, "vehicles": vehicle_models, "sonars": sonars, "modems": modems, "sequences": sequences,
}  # fmt: skip
"""By the kind that a flag states."""


def offer_fast() -> None:
    """Skip typer's slow imports in a process that only completes words.

    Typer imports pydantic, which completion does not need, and rich for markup, which our help does not use.
    """

    def process_value(self: Any, ctx: Any, value: Any) -> Any:
        return value

    for kind in (TyperArgument, TyperOption):
        kind.process_value = process_value  # type: ignore[method-assign]
    sys.modules["rich"] = None  # type: ignore[assignment]  # as if it were not installed


def one_of(*known: str) -> dict[str, Any]:
    """Return typer's settings for a parameter that accepts one or several of these words."""

    def check(param: typer.CallbackParam, value: Any) -> Any:
        for word in value if isinstance(value, list) else (value,):
            require_one_of(option_name(param), word, known)
        return value

    return {"callback": check, "autocompletion": words(*known)}
