"""Licences of what a wheel carries: `python -m tools.wheel_licences add TREE` and `check WHEEL`, both for tools/wheel.

They lie in *.dist-info/licenses, where installers and scanners look (PEP 639): a file for each library in uwsim.libs,
one for each Debian package whose headers or archives are compiled into the module, and pybind11's.
"""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from email import message_from_string
from importlib import metadata
from pathlib import Path, PurePosixPath

from tools.licence_list import HEADERS

HASH = re.compile(r"-[0-9a-f]{8}(?=\.so)")
"""The suffix that auditwheel adds to a library's name."""


def wanted(names: list[str]) -> dict[str, str]:
    """Return the licence files that a wheel with these files needs, each with the library or package it is of."""
    libraries = [HASH.sub("", PurePosixPath(name).name) for name in names if ".libs/" in name and ".so" in name]
    return {f"{each}.copyright": each for each in [*libraries, *HEADERS]} | {"pybind11.LICENSE": "pybind11"}


def add(tree: Path) -> None:
    """Add the licences to an unpacked wheel, and name them in its METADATA. Raises OSError if one is unknown."""
    (info,) = tree.glob("*.dist-info")
    folder = info / "licenses"
    folder.mkdir(exist_ok=True)
    files = wanted([str(path.relative_to(tree)) for path in tree.rglob("*")])
    for name, of in files.items():
        (folder / name).write_text(_pybind11() if of == "pybind11" else _copyright(of))
    described = (info / "METADATA").read_text()
    head, blank, text = described.partition("\n\n")
    lines = "".join(f"\nLicense-File: {name}" for name in files)
    (info / "METADATA").write_text(f"{head}{lines}{blank}{text}")


def missing(wheel: Path) -> list[str]:
    """Return the licences that a wheel lacks, by the files inside it."""
    with zipfile.ZipFile(wheel) as opened:
        (described,) = (name for name in opened.namelist() if name.endswith(".dist-info/METADATA"))
        folder = described.removesuffix("METADATA") + "licenses/"
        named = message_from_string(opened.read(described).decode()).get_all("License-File") or []
        there = {name for name in opened.namelist() if opened.getinfo(name).file_size > 100}
        needed = {"LICENSE", *wanted(opened.namelist()), *named}
    return sorted(name for name in needed if folder + name not in there or name not in named)


def _copyright(of: str) -> str:
    package = of
    if ".so" in of:
        owners = subprocess.run(["dpkg-query", "--search", f"*/{of}*"], capture_output=True, text=True, check=False)
        package = owners.stdout.partition(":")[0]
    return Path(f"/usr/share/doc/{package or of}/copyright").read_text(errors="replace")


def _pybind11() -> str:
    (file,) = (each for each in metadata.files("pybind11") or () if each.name == "LICENSE")
    return Path(str(file.locate())).read_text()


def main() -> None:
    """Add, or check and exit with 1 if a licence is missing."""
    match sys.argv[1:]:
        case ["add", tree]:
            add(Path(tree))
        case ["check", wheel]:
            if lacking := missing(Path(wheel)):
                sys.exit(f"{wheel}: lacks the licences {', '.join(lacking)}")
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
