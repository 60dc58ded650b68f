"""Descriptions of robots and their worlds, as sources of scenarios."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from uwsim.base.reader import Reader
from uwsim.exchange.robots.checkout import calibrations, descriptions, is_checkout
from uwsim.exchange.robots.robot import Description, Given, plain_name
from uwsim.exchange.scenario_source import Made, NotMadeError
from uwsim.scenario.read.note import Note

TRIED = 20
"""Descriptions of a checkout that are tried."""


def _xml(suffixes: tuple[str, ...], root: bytes) -> Callable[[Path, bytes], bool]:
    def accepts(path: Path, head: bytes) -> bool:
        suffix = path.suffix.lower()
        return path.is_file() and (suffix in suffixes or (suffix == ".xml" and b"<" + root in head))

    return accepts


def _make(module: str, function: str) -> Callable[[Path, Path | None, Mapping[str, Any]], Made]:
    def make(path: Path, out: Path | None, given: Mapping[str, Any]) -> Made:
        from uwsim.exchange.robots.written import write_found

        found = Description(plain_name(path.stem), Given(**given))
        try:
            getattr(import_module(f"uwsim.exchange.robots.{module}"), function)(path, found)
            try:
                return Made(write_found(found, out or Path(found.name)), found.all_notes())
            except ValueError as error:
                raise ValueError(f"'{path}': as converted: {error}") from None
        except ValueError as error:
            raise NotMadeError(str(error), found.all_notes()) from None

    return make


def _from_checkout(folder: Path, out: Path | None, given: Mapping[str, Any]) -> Made:
    """Make the scenario of the likeliest description that is a vehicle, and name the others."""
    files = descriptions(folder)
    refused: list[Note] = []
    given = {**given, "calibrations": calibrations(folder)}
    for file in files[:TRIED]:
        source = next(each for each in (SDF, URDF, STONEFISH) if each.accepts(file, b""))
        try:
            made = source.read(file, out, {key: given[key] for key in given.keys() & {*source.options, "calibrations"}})
        except (ValueError, OSError) as error:
            refused.append(Note("refused", str(error)))
            continue
        others = [str(each.relative_to(folder)) for each in files if each != file]
        beside = f"; others: {', '.join(others)}" if others else ""
        read = Note("read", f"{file.relative_to(folder)}, the likeliest{beside}")
        return Made(made.path, [read, *refused, *made.notes])
    raise NotMadeError(f"'{folder}': none of its {len(files)} descriptions of robots can be converted", refused)


ROBOT_OPTIONS = ("outfit", "progress")
SDF = Reader("an SDF file", _xml((".sdf", ".world"), b"sdf"), _make("sdf", "read_sdf"), ROBOT_OPTIONS)
URDF = Reader(
    "a URDF file", _xml((".urdf", ".xacro"), b"robot"), _make("urdf", "read_urdf"), ("arguments", *ROBOT_OPTIONS)
)
OPTIONS = ("arguments", "data", *ROBOT_OPTIONS)
STONEFISH = Reader("a Stonefish .scn file", _xml((".scn",), b"scenario"), _make("stonefish", "read_stonefish"), OPTIONS)
CHECKOUT = Reader("a folder with the description of a robot", is_checkout, _from_checkout, OPTIONS)
