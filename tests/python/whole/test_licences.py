"""Everything that users run has a licence compatible with uwsim's own, MIT."""

import re
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from tools.licence_list import HEADERS, main, reaches
from tools.wheel_licences import add, missing

ROOT = Path(__file__).parents[3]


def test_every_dependency_has_a_licence_and_none_reaches_to_us(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["licences"])
    assert main() == 0, capsys.readouterr().err
    listed = {line.split()[1] for line in capsys.readouterr().out.splitlines()}
    assert {"numpy", "liboctomap-dev", "pybind11", "three"} <= listed
    assert {"libembree3-3", "libembree4-4"} & listed


@pytest.mark.parametrize(("licence", "far"), [
    ("MIT", False), ("GNU General Public License v3 or later (GPLv3+)", True), ("AGPL-3.0-only", True),
    ("GNU Library or Lesser General Public License (LGPL)", False), ("GPL-3.0-or-later WITH GCC-exception-3.1", False),
    ("Apache-2.0 OR GPL-2.0", False),
])  # fmt: skip
def test_which_licences_reach(licence: str, far: bool) -> None:
    assert reaches(licence) == far


def test_a_wheel_carries_the_licences_of_what_is_inside(tmp_path: Path) -> None:
    bullet = next(path.name for path in Path("/usr/lib").glob("*/libLinearMath.so.*"))
    tree, info = tmp_path / "uwsim-1", tmp_path / "uwsim-1/uwsim-1.dist-info"
    for folder in (info / "licenses", tree / "uwsim.libs"):
        folder.mkdir(parents=True)
    (info / "METADATA").write_text("Name: uwsim\nLicense-File: LICENSE\n\nLong text.\n")
    (info / "licenses/LICENSE").write_text((ROOT / "LICENSE").read_text())
    (tree / "uwsim.libs" / bullet.replace(".so", "-0123abcd.so")).write_text("")

    def packed() -> list[str]:
        with zipfile.ZipFile(tmp_path / "made.whl", "w") as wheel:
            for path in sorted(tree.rglob("*")):
                wheel.write(path, path.relative_to(tree))
        return missing(tmp_path / "made.whl")

    everything = sorted([f"{bullet}.copyright", *(f"{each}.copyright" for each in HEADERS), "pybind11.LICENSE"])
    assert packed() == everything
    add(tree)
    assert packed() == []
    assert "zlib" in (info / f"licenses/{bullet}.copyright").read_text().lower()
    assert "redistribut" in (info / "licenses/pybind11.LICENSE").read_text().lower()
    assert (info / "METADATA").read_text().endswith("LICENSE\n\nLong text.\n")
    (info / "licenses/libpcl-dev.copyright").unlink()
    assert packed() == ["libpcl-dev.copyright"]


@pytest.mark.parametrize("name", ["requirements-lock.txt", "requirements-lock-dev.txt"])
def test_a_lock_holds_what_users_need_by_version_and_hash(name: str) -> None:
    entries = [line for line in (ROOT / name).read_text().replace("\\\n", " ").splitlines() if line.strip()]
    assert all("==" in entry and "--hash=sha256:" in entry for entry in entries)
    locked = {entry.partition("==")[0].partition("[")[0]: entry.split()[0].partition("==")[2] for entry in entries}
    config = tomllib.loads((ROOT / "pyproject.toml").read_text())
    for wanted in map(Requirement, [*config["build-system"]["requires"], *config["project"]["dependencies"]]):
        version = locked[re.sub(r"[-_.]+", "-", wanted.name).lower()]
        assert wanted.specifier.contains(version), f"{wanted}: locked is {version}; run tools/lock"
