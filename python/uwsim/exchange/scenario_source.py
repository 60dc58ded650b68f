"""Formats that `uwsim scenario from` reads: one object each, in the group `uwsim.scenario_sources` of entry points."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from uwsim.base import sockets

GROUP = "uwsim.scenario_sources"


class Made(NamedTuple):
    """The scenario's file, and a line for each element that was left out or assumed."""

    path: Path
    notes: list[str]


class NotMadeError(ValueError):
    """A source of which no scenario can be made. notes: a line for all that was read, left out or assumed before."""

    def __init__(self, rule: str, notes: list[str]) -> None:
        super().__init__(rule)
        self.notes = notes


@dataclass(frozen=True)
class ScenarioSource:
    """A format. what: for messages, such as `a URDF file`. accepts: whether a path looks like one, at little cost.

    make: called with the path, the folder to write, or None for one named after the scenario, and the options of the
    command line that are among `options`. It raises ValueError (of NotMadeError, the notes are printed) or OSError, and
    then has written nothing.
    """

    what: str
    accepts: Callable[[Path], bool]
    make: Callable[[Path, Path | None, Mapping[str, Any]], Made]
    options: tuple[str, ...] = ()


def source_of(path: Path) -> ScenarioSource:
    """Return the format of a file or folder. Raises ValueError for one that no format accepts, and OSError."""
    if not path.exists():
        raise FileNotFoundError(f"'{path}': there is no such file or folder")
    sources: Mapping[str, ScenarioSource] = sockets.load_all(GROUP, _source)
    for name, source in sources.items():
        entry = sockets.registered(GROUP)[name]
        try:
            if source.accepts(path):
                return source
        except Exception as error:  # another package's code may raise anything
            if entry.is_own:
                raise
            what = sockets.blamed(GROUP, entry, error, "accepts")
            warnings.warn(f"{what}; not asked further", sockets.SocketWarning, stacklevel=2)
    raise ValueError(f"'{path}': must be {', '.join(source.what for source in sources.values())}")


def _source(name: str, found: object) -> ScenarioSource:
    if not isinstance(found, ScenarioSource):
        raise TypeError(f"{name}: must be a ScenarioSource")
    return found
