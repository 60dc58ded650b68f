"""A robot in a checkout: the description that a folder, such as that of a ROS package, offers first."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from uwsim.base.texts.text_file import read_limited
from uwsim.exchange.xml_text import xml_root

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
