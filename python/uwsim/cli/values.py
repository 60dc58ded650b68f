"""What a shell offers for the values of arguments and options. Where nothing fits, it offers files."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from typer.core import TyperArgument, TyperOption

Completer = Callable[[str], list[str]]
"""Typer's autocompletion: from the beginning of a word to the words that it may become."""


def packaged_folder(name: str, in_sources: str) -> Path:
    """Return a folder inside an installed package, or that of the source tree."""
    package = Path(__file__).resolve().parents[1]
    return next(folder for folder in (package / name, package.parents[1] / in_sources) if folder.is_dir())


def words(*known: str) -> Completer:
    """Offer these."""

    def complete(incomplete: str) -> list[str]:
        return [word for word in known if word.startswith(incomplete)]

    return complete


def packaged(kind: str, *others: str) -> Completer:
    """Offer the packaged files of a folder of the assets, others, and the YAML files of the current folder.

    It lists folders itself, since `uwsim.scenario` is slow to import.
    """

    def complete(incomplete: str) -> list[str]:
        names = sorted(path.stem for path in (packaged_folder("assets", "assets") / kind).glob("*.yaml"))
        here = sorted(path.name for path in Path().glob("*.y*ml"))
        return words(*others, *names, *here)(incomplete)

    return complete


scenarios = packaged("scenarios")
sonars = packaged("sonars", "1", "2", "3", "4")
modems = packaged("modems")


def offer_fast() -> None:
    """Keep typer from what takes most of the time in a process that only tells a shell what to offer.

    For values, which nothing uses there, it imports pydantic; for markup, which our help has none of, rich.
    """

    def process_value(self: Any, ctx: Any, value: Any) -> Any:
        return value

    for kind in (TyperArgument, TyperOption):
        kind.process_value = process_value  # type: ignore[method-assign]
    sys.modules["rich"] = None  # type: ignore[assignment]  # as if it were not installed
