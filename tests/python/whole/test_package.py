"""The package's own papers agree with each other, and a plain installation is light."""

import json
import re
import tomllib
from pathlib import Path

from ruamel.yaml import YAML

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_every_paper_states_the_same_version_and_authors() -> None:
    citation = YAML(typ="safe").load(ROOT / "CITATION.cff")
    meta = json.loads((ROOT / "codemeta.json").read_text())
    newest = re.search(r"^## \[(\d.*?)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert newest
    assert {PROJECT["version"], str(citation["version"]), meta["version"], newest[1]} == {PROJECT["version"]}
    names = [PROJECT["authors"], citation["authors"], meta["author"]]
    assert [[each["name"] for each in authors] for authors in names] == [["The uwsim authors"]] * 3


def test_every_action_of_the_workflows_is_pinned_by_commit() -> None:
    used = [line for path in (ROOT / ".github/workflows").glob("*.yml") for line in path.read_text().splitlines()]
    actions = [line for line in used if "uses:" in line]
    assert actions
    assert [line for line in actions if not re.search(r"@[0-9a-f]{40} # v\d", line)] == []
