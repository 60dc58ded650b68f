"""Documented modules that have moved remain importable under their old names for one version, with a warning."""

import importlib
import re
import subprocess
import sys

import pytest

import uwsim
from docs_pages import PAGES, ROOT
from uwsim._moved import MOVED, new_name


@pytest.mark.parametrize("old", MOVED)
def test_an_old_name_leads_to_the_module_itself(old: str) -> None:
    sys.modules.pop(old, None)
    with pytest.warns(DeprecationWarning, match=f"{old} has moved: import {MOVED[old]}"):
        module = importlib.import_module(old)
    assert module is importlib.import_module(MOVED[old])
    assert module.__name__ == MOVED[old]
    assert module.__spec__ is not None and module.__spec__.name == MOVED[old]


def test_what_is_inside_a_moved_package_is_found_too() -> None:
    program = (
        "from uwsim.sonars.multibeam import Sonar; from uwsim import ranging; print(Sonar.__module__, ranging.__name__)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["uwsim.instruments.sonars.multibeam", "uwsim.mapping.ranging"]


def test_a_name_that_has_not_moved_is_left_alone() -> None:
    assert new_name("uwsim.mapping") is None
    assert new_name("uwsim.sensors_of_mine") is None
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("uwsim.nowhere")
    assert uwsim.OccupancyMap.__name__ == "OccupancyMap"


def test_no_page_documents_an_old_name() -> None:
    """Entries of the changelog may: those that state that a name has moved."""
    found = []
    for page in [ROOT / "README.md", *PAGES, ROOT / "CHANGELOG.md"]:
        entries = re.split(r"^(?=- )", page.read_text(), flags=re.MULTILINE)
        text = "".join(entry for entry in entries if not re.search(r"\bmoved\b|\bold\s+names\b", entry))
        found += [(page.name, old) for old in MOVED if re.search(rf"(?<![\w/]){re.escape(old)}(?![\w/])", text)]
    assert not found
