"""Implementation of `tools/licences`."""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
HEADERS = ("libeigen3-dev", "liboctomap-dev", "libdynamicedt3d-dev", "libpcl-dev", "libbullet-dev")
"""Debian packages whose headers or archives are compiled into the native module."""
WHOLE_LICENCES = {
    "libc6": "LGPL-2.1-or-later",
    "libgcc-s1": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "libgomp1": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "liblz4-1": "BSD-2-Clause",
    "libstdc++6": "GPL-3.0-or-later WITH GCC-exception-3.1",
}
"""Licences of packages whose copyright file lists many parts, most of which are not in the library."""
REACHING = re.compile(r"\bA?GPL|GNU (Affero )?General Public", re.IGNORECASE)


def main() -> int:
    """Print a table; return 1 if a licence is unknown or has a wider reach than allowed."""
    parser = argparse.ArgumentParser(prog="tools/licences", description="List dependencies and their licences.")
    parser.add_argument("--all", action="store_true", help="also list what tests and linters need")
    everything = parser.parse_args().all
    rows = [*python_packages(everything), *_libraries(), *headers(), *javascript()]
    width = max(len(name) for _, name, _, _ in rows)
    wrong = []
    for kind, name, version, licence in rows:
        print(f"{kind:<10} {name:<{width}} {version:<28} {licence or 'UNKNOWN'}")
        if not licence or (kind != "test" and reaches(licence)):
            wrong.append(name)
    if wrong:
        print(f"licences: look at {', '.join(wrong)}", file=sys.stderr)
    return 1 if wrong else 0


def reaches(licence: str) -> bool:
    """Return True if each of the alternative licences extends beyond the files that it covers."""
    return all(
        REACHING.search(each) and "LGPL" not in each and "exception" not in each
        for each in re.split(r" or | OR ", licence)
    )


def python_packages(everything: bool) -> Iterable[tuple[str, str, str, str]]:
    """Yield kind, name, version and licence of the packages for uwsim and its extras and, if requested, for tests."""
    config = tomllib.loads((ROOT / "pyproject.toml").read_text())
    project = config["project"]
    extras = [line for lines in project["optional-dependencies"].values() for line in lines]
    needed = _closure(project["dependencies"])
    optional = _closure(line for line in extras if not line.startswith("uwsim["))
    test = _closure(line for line in config["dependency-groups"]["dev"] if line != "uwsim[all]") if everything else {}
    for name, found in sorted({**test, **optional, **needed}.items()):
        kind = "Python" if name in needed else "optional" if name in optional else "test"
        yield kind, name, found.version, _licence_of(found)


def _closure(requirements: Iterable[str]) -> dict[str, metadata.Distribution]:
    """Return the installed packages among these, with all their transitive requirements."""
    found: dict[str, metadata.Distribution] = {}
    waiting = [Requirement(line) for line in requirements]
    while waiting:
        wanted = waiting.pop()
        name = re.sub(r"[-_.]+", "-", wanted.name).lower()
        if name in found or (wanted.marker and not _applies(wanted)):
            continue
        try:
            found[name] = metadata.distribution(wanted.name)
        except metadata.PackageNotFoundError:
            continue
        for line in found[name].requires or ():
            inner = Requirement(line)
            if inner.marker is None or any(inner.marker.evaluate({"extra": extra}) for extra in ("", *wanted.extras)):
                inner.marker = None
                waiting.append(inner)
    return found


def _applies(requirement: Requirement) -> bool:
    return requirement.marker is None or requirement.marker.evaluate({"extra": ""})


def _licence_of(found: metadata.Distribution) -> str:
    """Return the licence expression, or else the classifiers, or else the first line of the text or licence file."""
    said = found.metadata
    if said.get("License-Expression"):
        return str(said["License-Expression"])
    prefix = "License :: "
    named = [each.split(" :: ")[-1] for each in said.get_all("Classifier") or () if each.startswith(prefix)]
    named = [each for each in named if each != "OSI Approved"]
    files = [file for file in found.files or () if file.name.startswith("LICENSE") and file.parent.name == "licenses"]
    text = (said.get("License") or (files[0].read_text() if files else "")).strip().splitlines()
    return " AND ".join(named) or (text[0][:60] if text else "")


def _libraries() -> Iterable[tuple[str, str, str, str]]:
    """Yield the Debian packages of the libraries that the native module loads."""
    from uwsim import _core

    listed = subprocess.run(["ldd", _core.__file__], capture_output=True, text=True, check=True).stdout
    paths = sorted({str(Path(path).resolve()) for path in re.findall(r"=> (/\S+)", listed)})
    packages = {package for path in paths if (package := _package_of(path))}
    for package in sorted(packages):
        yield "library", package, debian_version(package), debian_licence(package)


def headers() -> Iterable[tuple[str, str, str, str]]:
    """Yield the libraries whose headers are compiled into the native module."""
    for package in HEADERS:
        yield "compiled", package, debian_version(package), debian_licence(package)
    yield "compiled", "pybind11", metadata.version("pybind11"), _licence_of(metadata.distribution("pybind11"))


def _package_of(path: str) -> str:
    for name in (path, path.removeprefix("/usr")):  # Debian's /lib is a link to /usr/lib
        ran = subprocess.run(["dpkg-query", "-S", name], capture_output=True, text=True, check=False)
        if ran.returncode == 0:
            return ran.stdout.split(":")[0]
    return ""


def debian_version(package: str) -> str:
    """Return the version of an installed Debian package."""
    query = ["dpkg-query", "-W", "-f", "${Version}\n", package]
    return subprocess.run(query, capture_output=True, text=True, check=True).stdout.splitlines()[0]


def debian_licence(package: str) -> str:
    """Return a library's licence: that of `Files: *` in Debian's copyright file, or else every licence it names."""
    if package in WHOLE_LICENCES:
        return WHOLE_LICENCES[package]
    path = Path("/usr/share/doc") / package / "copyright"
    text = path.read_text(errors="replace") if path.is_file() else ""
    whole = re.search(r"^Files: *\*.*?^License: *([^\n]+)", text, flags=re.MULTILINE | re.DOTALL)
    if whole:
        return whole[1].strip()
    named = re.findall(r"^License: *(\S[^\n]*)", text, flags=re.MULTILINE)
    known = re.findall(r"LGPL|Apache License|BSD|Boost Software License|zlib|MIT|MPL|GPL", text)
    return " AND ".join(dict.fromkeys(named or known))


def javascript() -> Iterable[tuple[str, str, str, str]]:
    """Yield the npm packages in the station's page."""
    lock = json.loads((ROOT / "tools" / "assets" / "station_vendor" / "package-lock.json").read_text())
    for path, package in lock["packages"].items():
        if path and not package.get("dev"):
            yield "page", path.removeprefix("node_modules/"), package["version"], package.get("license", "")


if __name__ == "__main__":
    sys.exit(main())
