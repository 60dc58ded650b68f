"""Expansion of macros by ROS's xacro, in a process: python xacro_process.py FILE [NAME=VALUE ...] MEMORY_BYTES CPU_S.

xacro evaluates expressions of the file, hence the limits. To start quickly, this must not import uwsim. stdout: the
document; stderr: xacro's warnings, and in the last line its error.
"""

from __future__ import annotations

import os
import resource
import sys
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

MANIFEST, LEVELS, WITHIN = "package.xml", 6, 3
"""The file that makes a folder a ROS package; folders above a file, and levels below each, where one is looked for."""
SEARCHED = {"ROS_PACKAGE_PATH": "", "AMENT_PREFIX_PATH": "share", "COLCON_PREFIX_PATH": "share"}


@lru_cache(maxsize=1024)
def package_folder(name: str, near: Path) -> Path | None:
    """Return the folder of a ROS package: around a file, in the same checkout, beside it, or in ROS's own paths."""
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
        return ElementTree.parse(folder / MANIFEST).findtext("name")
    except (OSError, ElementTree.ParseError):
        return None


def _index(near: Path) -> ModuleType:
    """Return ROS's index of packages, by which xacro resolves $(find NAME), of the folders about a file."""

    def get_package_share_directory(name: str) -> str:
        return str(package_folder(name, near) or f"package://{name}")  # an address that is not here, for messages

    index = ModuleType("ament_index_python.packages")
    index.get_package_share_directory = get_package_share_directory  # type: ignore[attr-defined]
    return index


def main() -> None:
    """Expand a file within the limits; on error, exit with code 1."""
    path, memory_bytes, cpu_s = Path(sys.argv[1]), int(sys.argv[-2]), int(sys.argv[-1])
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    for kind, limit in (
        (resource.RLIMIT_AS, memory_bytes),
        (resource.RLIMIT_CPU, cpu_s),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (limit, limit))
    sys.modules["ament_index_python"] = ModuleType("ament_index_python")
    sys.modules["ament_index_python.packages"] = _index(path)
    import xacro

    mappings = dict(each.partition("=")[::2] for each in sys.argv[2:-2])
    try:
        document = xacro.process_file(str(path), mappings=mappings)
    except Exception as error:  # of any type, since expressions are the file's
        sys.exit(" ".join(str(error).split()) or type(error).__name__)
    out.write(document.toxml())
    out.close()


if __name__ == "__main__":
    main()
