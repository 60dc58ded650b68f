"""Shell completion for values of arguments and options. Without a match, the shell offers files."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from typer.core import TyperArgument, TyperOption

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
