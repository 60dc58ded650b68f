"""A robot in a checkout: the description that a folder, such as that of a ROS package, offers first."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

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


def checkout_of(file: Path) -> Path | None:
    """Return the checkout in which a file is, if it is in one."""
    return next((folder for folder in file.resolve().parents if (folder / ".git").exists()), None)


def is_checkout(path: Path) -> bool:
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
