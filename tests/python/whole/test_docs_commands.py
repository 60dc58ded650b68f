"""Commands shown in the pages exist, with all their options; YAML in the pages is valid."""

import re
import shlex
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import typer
from ruamel.yaml import YAML

import docs_pages
from uwsim.campaigns.sweeps.spec import SweepSpec
from uwsim.cli.groups import WithDefault
from uwsim.cli.program import app
from uwsim.exercises import Exercise
from uwsim.scenario.schema import schema

PROGRAM: Any = typer.main.get_command(app)
PAGES = [docs_pages.ROOT / "README.md", docs_pages.ROOT / "CONTRIBUTING.md", *docs_pages.PAGES]


def commands(page: Path) -> Iterator[list[str]]:
    """Yield each `uwsim ...` command of a page, from code blocks and inline code."""
    lines = "\n".join(docs_pages.blocks(page, "sh")).splitlines() + re.findall(r"`(uwsim [^`]*)`", page.read_text())
    for line in lines:
        command = re.match(r"(?:\.venv/bin/)?uwsim ([a-z].*)", line.strip())
        if command and not re.search(r"\.\.\.|\[", command[1]):
            yield shlex.split(command[1].split(" | ")[0], comments=True)


def unknown(words: list[str]) -> set[str]:
    """Return the words of a command that the program does not know."""
    program = PROGRAM
    if words[0] == "bench":  # each benchmark has its own options
        return set()
    if hasattr(program.commands.get(words[0]), "commands"):
        program, words = program.commands[words[0]], words[1:]
        if isinstance(program, WithDefault):
            words = program.spelled_out(typer.Context(program), words)
    if not words or words[0] not in program.commands:
        return set(words[:1])
    command = program.commands[words[0]]
    known = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
    given = {word.partition("=")[0] for word in words[1:] if re.match("--?[a-z]", word)}
    return given - known - {"-h", "--help"}


@pytest.mark.parametrize("page", [page for page in PAGES if any(commands(page))], ids=lambda page: page.stem)
def test_commands_are_known_with_their_options(page: Path) -> None:
    assert {" ".join(words): unknown(words) for words in commands(page) if unknown(words)} == {}


def documents() -> Iterator[tuple[str, Any]]:
    for page in PAGES:
        for text in docs_pages.blocks(page, "yaml"):
            yield page.stem, YAML(typ="safe").load(text)


schema_once = cache(schema)


@cache
def own_schema(key: str) -> dict[str, Any] | None:
    """Return the schema for one key of a scenario or vehicle."""
    for part in ("scenario", "vehicle"):
        whole = schema_once(part)
        if key in whole["properties"]:
            return whole["properties"][key] | {"definitions": whole["definitions"]}
    return None


OTHERS = {
    "ci": "a workflow of GitHub",
    "extend": "the kinds of its package",
}


@pytest.mark.parametrize(("page", "document"), [each for each in documents() if each[0] not in OTHERS and each[1]])
def test_yaml_is_accepted(page: str, document: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if "vary" in document:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "mow.py").touch()  # the mission shown on the page
        SweepSpec.model_validate(document)
        return
    if "goals" in document:
        Exercise.model_validate(document)
        return
    for key, value in document.items():
        expected = own_schema(key)
        assert expected is not None, key
        assert [error.message for error in jsonschema.Draft7Validator(expected).iter_errors(value)] == []
