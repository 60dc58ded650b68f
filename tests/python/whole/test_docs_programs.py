"""The Python programs in the documentation run as printed: all programs of a page, in order."""

import contextlib
import inspect
import pydoc
import re
import runpy
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import nbformat
import pytest
from sphinx.search.en import SearchEnglish
from tools.notebooks import is_fresh
from tools.reference.python_names import PUBLIC

import docs_pages
import uwsim
from command_line import left_as_found
from docs_pages import DOCS, blocks, page_named
from uwsim.campaigns.sweeps.spec import SweepSpec
from uwsim.scenario.schema import PARTS, schema

ELSEWHERE = {
    "makers": "needs Blue Robotics' library; test_ping.py uses it where it is there",
    "rosbridge": "needs a server; test_readme.py runs the README's, which is alike",
}
HIDDEN = (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning)
"""Warning categories that Python hides by default."""
PAGES = sorted(path.stem for path in docs_pages.PAGES if blocks(path, "python") and path.stem not in ELSEWHERE)


@pytest.mark.parametrize("page", PAGES)
def test_the_programs_of_a_page_run(
    page: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], recwarn: pytest.WarningsRecorder
) -> None:
    """Runs in this process to avoid repeated imports; test_readme.py starts processes."""
    programs = "\n".join(blocks(page_named(page), "python"))
    with left_as_found(), contextlib.chdir(tmp_path):
        exec(compile(programs, page, "exec"), {"__name__": "__main__"})
    assert capfd.readouterr().err == ""
    assert [str(each.message) for each in recwarn if not issubclass(each.category, HIDDEN)] == []


def test_the_reference_pages_follow_from_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["reference", str(tmp_path)])
    runpy.run_module("tools.reference", run_name="__main__")  # tools/docs starts a process
    for page in tmp_path.glob("*.md"):
        if page.stem != "benchmarks":  # it depends on measurements
            kept = (DOCS / "reference" / page.name).read_text()
            assert kept == page.read_text(), f"{page.name}: run python -m tools.reference docs/reference"
    scenario = (tmp_path / "scenario.md").read_text()
    assert "| `step_s` | number in 0.0005 ... 0.02 s | `0.005` |" in scenario
    assert "rov | `usbl` | 1 | 0 | 0.05 |" in (tmp_path / "sensors.md").read_text()
    assert "## uwsim survey" in (tmp_path / "commands.md").read_text()
    published, received = (tmp_path / "channels.md").read_text().split("## Received")
    assert "`scan`" in published and "`cmd_vel`" in received
    assert "| 0 to 2 | `place_body` | m | -10 ... 10 | 0.2 |" in (tmp_path / "environments.md").read_text()
    assert "| `retries` | whole number in 0 ... 100 | `2` |" in (tmp_path / "sweep.md").read_text()
    assert "Francois and Garrison 1982" in (tmp_path / "sources.md").read_text()


def test_the_search_of_the_site_finds_every_key() -> None:
    """Each key is a word of the reference pages, and none that Sphinx leaves out of its index.

    `on`, `then`, `to` and `up` are stop words of English search.
    """
    language = SearchEnglish({})
    pages = " ".join(path.read_text().lower() for path in (DOCS / "reference").glob("*.md"))
    stems = map(language.stem, set(language.split(pages)))
    indexed = {stem for stem in stems if language.word_filter(stem)}
    keys = {key for part in PARTS for key in keys_of(schema(part))} | set(SweepSpec.model_fields)
    assert len(keys) > 350
    assert {key for key in keys if language.stem(key.lower()) not in indexed} == {"on", "then", "to", "up"}


def test_the_search_of_the_site_finds_what_newcomers_look_for() -> None:
    language = SearchEnglish({})
    words = set(language.split(" ".join(path.read_text().lower() for path in docs_pages.PAGES)))
    asked = "docker pytorch license swarm matlab side-scan benchmark bibtex wheel container"
    parts = set(language.split(asked))
    assert "side" in parts and [part for part in parts if not language.word_filter(part)] == []
    assert parts <= words, parts - words


def keys_of(part: Any) -> set[str]:
    """Return the keys of a schema and of all that it contains."""
    if isinstance(part, list):
        return {key for item in part for key in keys_of(item)}
    if not isinstance(part, dict):
        return set()
    own = set(part["properties"]) if isinstance(part.get("properties"), dict) else set()
    return own.union(*(keys_of(item) for item in part.values()))


def test_what_the_programs_import_is_public() -> None:
    """Everything imported is in the Python reference, so a copied program does not rely on internals."""
    listed = [name.removesuffix("()") for names in PUBLIC.values() for name in names]
    texts = ["\n".join(blocks(page_named(page), "python")) for page in PAGES]
    texts += [path.read_text().replace("\\n", "\n").replace('"', " ") for path in (DOCS / "notebooks").glob("*.ipynb")]
    imports = {
        (module, name.strip())
        for text in texts
        for module, names in re.findall(r"^ *from (uwsim[\w.]*) import ([\w, ]+)", text, flags=re.MULTILINE)
        for name in names.split(",")
    }
    assert len(imports) > 10
    things = [pydoc.locate(name) for name in listed] + [getattr(uwsim, name) for name in uwsim.__all__]
    for module, name in sorted(imports):
        home = import_module(module)
        thing = getattr(home, name) if hasattr(home, name) else import_module(f"{module}.{name}")
        inside = any(inspect.ismodule(each) and getattr(each, name, None) is thing for each in things)
        holds = inspect.ismodule(thing) and any(each.startswith(thing.__name__) for each in listed)
        assert inside or holds or any(thing is each for each in things), f"{module}.{name}"


def test_notebooks_are_kept_with_what_their_code_gave() -> None:
    """Read on the web as they are; `python -m tools.notebooks` runs those whose code has changed."""
    notebooks = sorted((DOCS / "notebooks").glob("*.ipynb"))
    assert len(notebooks) >= 6
    for path in notebooks:
        notebook = nbformat.read(path, as_version=4)
        assert is_fresh(notebook), f"{path.name}: run python -m tools.notebooks"
        given = [output for cell in notebook.cells for output in cell.get("outputs", [])]
        assert any("image/png" in output.get("data", {}) for output in given), f"{path.name}: no picture"
        assert not [output for output in given if output.output_type == "error"]
        next(cell for cell in notebook.cells if cell.cell_type == "code").source += "\n1"
        assert not is_fresh(notebook)
    assert sum(path.stat().st_size for path in notebooks) < 2_000_000


def test_every_picture_is_shown() -> None:
    texts = "".join(path.read_text() for path in [*docs_pages.PAGES, DOCS.parent / "README.md"])
    assert docs_pages.PICTURES
    for name in [path.name for path in docs_pages.PICTURES]:
        assert name in texts, name


def test_an_evenings_read_is_ten_functions_of_the_code_in_250_lines() -> None:
    page = DOCS / "inside/evening.md"
    shown = re.findall(r'literalinclude\} (\S+)\n.*\n:start-at: "(.*)"\n:end-before: "(.*)"', page.read_text())
    lengths = []
    for file, first, after in shown:
        lines = (page.parent / file).read_text().splitlines()
        begin = next(k for k, line in enumerate(lines) if first in line)
        lengths.append(next(k for k, line in enumerate(lines[begin:]) if k and after in line))
    assert len(lengths) == 10
    assert 200 <= sum(lengths) <= 300 and max(lengths) <= 50
