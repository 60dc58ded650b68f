"""Descriptions of robots as sources of scenarios: a file, or the first that a checkout, such as of ROS, offers."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

from uwsim.base.reader import Reader
from uwsim.base.texts.text_file import read_limited
from uwsim.exchange.robots.robot import Description, Given, plain_name
from uwsim.exchange.scenario_source import Made, NotMadeError
from uwsim.exchange.xml_text import xml_root
from uwsim.scenario.read.note import Note

LAUNCHES = (".launch", ".launch.py", ".launch.xml", ".launch.yaml")
DESCRIPTIONS = (".urdf", ".xacro", ".sdf", ".scn")
MARKS = {
    ".urdf": rb"thruster|buoyancy-engine",
    ".xacro": rb"<robot[^>]*\sname=",
    ".sdf": rb"thruster|buoyancy-engine",
    ".scn": rb"<robot|<include",
}
"""Text in a description that may be a whole robot, by suffix."""
CALIBRATION = b"camera_matrix"
SKIPPED = ("build", "install", "log", "node_modules")
FILES_MAX, BYTES_MAX = 20_000, 2_000_000
"""Files of a folder that are looked at, and bytes of each."""
MANIFEST, LEVELS, WITHIN = "package.xml", 6, 3
"""The file that makes a folder a ROS package; folders above a file, and levels below each, where one is looked for."""
PACKAGE_NAME = re.compile(r"\w[\w-]*")
SEARCHED = {"ROS_PACKAGE_PATH": "", "AMENT_PREFIX_PATH": "share", "COLCON_PREFIX_PATH": "share"}


def checkout_of(file: Path) -> Path | None:
    """Return the checkout in which a file is, if it is in one."""
    return next((folder for folder in file.resolve().parents if (folder / ".git").exists()), None)


def folder_of(file: Path) -> Path:
    """Return the folder whose files belong to one: its checkout, else its ROS package, else its own folder."""
    above = file.resolve().parents
    return checkout_of(file) or next((each for each in above if (each / MANIFEST).is_file()), above[0])


@lru_cache(maxsize=1024)
def package_folder(name: str, near: Path) -> Path | None:
    """Return the folder of a ROS package: around a file, in the same checkout, beside it, or in ROS's own paths."""
    if not PACKAGE_NAME.fullmatch(name):
        return None
    above = [folder for folder in near.resolve().parents if folder != Path(folder.anchor)][:LEVELS]
    for folder in above:
        if folder.name == name or _named(folder) == name:
            return folder
        if (folder / name).is_dir():
            return folder / name
    beside = False  # whether a folder holds the checkout, and others: a workspace
    for folder in above:
        for level in range(1, WITHIN + 1):
            for manifest in folder.glob("*/" * level + MANIFEST):
                if manifest.parent.name == name or _named(manifest.parent) == name:
                    return manifest.parent
        if beside:
            break
        beside = (folder / ".git").exists()
    for key, below in SEARCHED.items():
        for text in os.environ.get(key, "").split(os.pathsep):
            if text and (folder := Path(text) / below / name).is_dir():
                return folder
    return None


@lru_cache(maxsize=4096)
def _named(folder: Path) -> str | None:
    try:
        return xml_root(read_limited(folder / MANIFEST, MANIFEST, BYTES_MAX), MANIFEST).findtext("name")
    except ValueError:
        return None


def is_checkout(path: Path, head: bytes) -> bool:
    """Return whether a path is a folder with a description in it."""
    return path.is_dir() and next(_files(path, DESCRIPTIONS), None) is not None


def descriptions(folder: Path) -> list[Path]:
    """Return the descriptions in a folder that may be whole robots, the likeliest first.

    A launch file that names one, a folder `robots`, and the least deep and shortest name make it likely.
    """
    launched = b"\n".join(file.read_bytes()[:BYTES_MAX] for file in _files(folder, LAUNCHES))
    found = [file for file in _files(folder, DESCRIPTIONS) if _may_be_robot(file)]
    return sorted(
        found,
        key=lambda file: (
            not re.search(rb"(?<![\w.-])" + re.escape(file.name.encode()) + rb"(?![\w.])", launched),
            "robots" not in file.parts,
            "test" in str(file.relative_to(folder)),
            len(file.relative_to(folder).parts),
            len(file.name),
            str(file),
        ),
    )


def calibrations(folder: Path) -> tuple[Path, ...]:
    """Return the calibrations of cameras in a folder, by ROS or OpenCV."""
    return tuple(file for file in _files(folder, (".yaml", ".yml")) if CALIBRATION in file.read_bytes()[:BYTES_MAX])


def _may_be_robot(file: Path) -> bool:
    return re.search(MARKS[file.suffix.lower()], file.read_bytes()[:BYTES_MAX]) is not None


def _files(folder: Path, suffixes: tuple[str, ...]) -> Iterator[Path]:
    """Yield files with one of the suffixes, in the order of their paths, but in hidden and built folders."""
    seen = 0
    for at, folders, names in os.walk(folder):
        folders[:] = sorted(each for each in folders if not each.startswith(".") and each not in SKIPPED)
        for name in sorted(names):
            seen += 1
            if seen > FILES_MAX:
                return
            if name.lower().endswith(suffixes) and (Path(at) / name).is_file():
                yield Path(at) / name


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
