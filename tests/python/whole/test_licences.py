"""Everything that users run has a licence compatible with uwsim's own, MIT, and a locked version."""

import re
import subprocess
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[3]


def test_every_package_has_a_licence_and_none_reaches_to_us() -> None:
    listed = subprocess.run([ROOT / "tools/licences"], capture_output=True, text=True, check=False)
    assert listed.returncode == 0, listed.stderr
    assert {'"numpy"', '"uwsim"'} <= {line.partition(",")[0] for line in listed.stdout.splitlines()}


@pytest.mark.parametrize("name", ["requirements-lock.txt", "requirements-lock-dev.txt"])
def test_a_lock_holds_what_users_need_by_version_and_hash(name: str) -> None:
    entries = [line for line in (ROOT / name).read_text().replace("\\\n", " ").splitlines() if line.strip()]
    assert all("==" in entry and "--hash=sha256:" in entry for entry in entries)
    locked = {entry.partition("==")[0].partition("[")[0]: entry.split()[0].partition("==")[2] for entry in entries}
    config = tomllib.loads((ROOT / "pyproject.toml").read_text())
    for wanted in map(Requirement, [*config["build-system"]["requires"], *config["project"]["dependencies"]]):
        version = locked[re.sub(r"[-_.]+", "-", wanted.name).lower()]
        assert wanted.specifier.contains(version), f"{wanted}: locked is {version}; run tools/lock"
