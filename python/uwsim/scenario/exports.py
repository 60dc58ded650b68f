"""Formats of other simulators: an object each, in the group `uwsim.scenario_exports` of entry points, by suffix."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from uwsim.base import sockets
from uwsim.scenario.spec.scenario import Scenario

GROUP = "uwsim.scenario_exports"


class Exported(NamedTuple):
    """The files of a scenario by their relative paths, the world's first, and a line for all left out or assumed."""

    files: Mapping[str, bytes]
    notes: list[str]


@dataclass(frozen=True)
class ScenarioExport:
    """A format. simulator: its name.

    make: returns the content of the world's file, under "", and of those beside it, which it refers to in a folder of
    this name; and the notes. It raises ValueError (as ScenarioError) for a scenario that cannot be written.
    """

    simulator: str
    make: Callable[[Scenario, str], Exported]


def formats() -> Mapping[str, ScenarioExport]:
    """Return the formats by their suffix, without its point."""
    return sockets.load_all(GROUP, _format)


def require_known(suffix: str) -> None:
    """Raise ValueError for a suffix that no format has."""
    if suffix not in formats():
        known = (f".{name}, for {each.simulator}" for name, each in formats().items())
        raise ValueError(f"must end in {' or '.join(known)}")


def export(scenario: Scenario, name: str, suffix: str) -> Exported:
    """Return a scenario in a format: NAME.SUFFIX, and a folder NAME_SUFFIX. Raises ValueError."""
    require_known(suffix)
    folder = f"{name}_{suffix}"
    with sockets.blaming(GROUP, suffix, "make", passes=(ValueError, OSError)):
        files, notes = formats()[suffix].make(scenario, folder)
    return Exported({f"{folder}/{each}" if each else f"{name}.{suffix}": files[each] for each in ("", *files)}, notes)


def zipped(files: Mapping[str, bytes]) -> bytes:
    """Return files as a ZIP archive, the same bytes for the same files."""
    found = io.BytesIO()
    with zipfile.ZipFile(found, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for path, content in files.items():
            archive.writestr(zipfile.ZipInfo(path), content, zipfile.ZIP_DEFLATED)
    return found.getvalue()


def _format(name: str, found: object) -> ScenarioExport:
    if not isinstance(found, ScenarioExport):
        raise TypeError(f"{name}: must be a ScenarioExport")
    return found
