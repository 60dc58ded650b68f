"""Commands under the noun that they serve: defaults of groups, what is gone, and suggestions."""

import os
import re
from pathlib import Path
from typing import Any

import pytest
import typer

from command_line import error_line, uwsim, uwsim_process
from uwsim.cli.groups import GONE
from uwsim.cli.program import app

PROGRAM: Any = typer.main.get_command(app)
WORDS = {
    "rays": "pool --from=0,0,-1 --to 1,1,-1 --json",
    "connect": "ws://host pool --ros 2",
    "nodes": "octomap --url ws://host",
    "doctor": "--listen 1 --ros-domain-id 3",
    "diff": "a b --json",
    "tune": "rov --generations 3",
    "parameters": "pool rov --json",
    "decompose": "a --up y",
    "identify": "a --vehicle rov --known mass_kg",
    "fingerprint": "pool --seed 3",
    "sonar": "pool --kind fan",
    "camera": "pool --sun 30",
    "film": "run.mcap --fps 5",
}
NOTEBOOKS = {old: there for old, there in GONE.items() if there.startswith("docs/")}
DEFAULTS = {"vehicle": "report", "exercise": "fly", "recording": "info"}


def parsed(words: list[str]) -> tuple[str, dict[str, Any]]:
    """Return the path and the parameters of the command that a line runs."""
    context, command = PROGRAM.make_context("uwsim", list(words)), PROGRAM
    while hasattr(command, "commands"):
        name, command, rest = command.resolve_command(context, [*context._protected_args, *context.args])
        context = command.make_context(name, rest, parent=context)
    return context.command_path, context.params


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a").touch(), (tmp_path / "b").touch()


@pytest.mark.parametrize("old", [old for old in GONE if old not in NOTEBOOKS])
def test_a_spelling_that_is_gone_is_refused_with_the_present_one(old: str) -> None:
    ran = uwsim(old, *WORDS[old].split())
    assert ran.returncode == 2 and f"it is 'uwsim {GONE[old]}' now" in error_line(ran)
    assert parsed([*GONE[old].split(), *WORDS[old].split()])[0] == f"uwsim {GONE[old]}"


def test_a_command_that_is_a_notebook_is_refused_with_its_file() -> None:
    ran, (name,) = uwsim("range", "vision"), NOTEBOOKS.values()
    assert ran.returncode == 2 and f"it is '{name}' now" in error_line(ran)
    assert (Path(__file__).parents[3] / name).is_file()


def test_help_lists_few_commands_and_no_old_spelling() -> None:
    listed = re.findall(r"^  ([a-z][a-z-]*)  +[A-Z]", uwsim("--help").stdout, flags=re.MULTILINE)
    assert len(listed) <= 22 and set(listed) == set(PROGRAM.commands) and not set(listed) & set(GONE)
    asked = {"_UWSIM_COMPLETE": "complete_bash", "COMP_WORDS": "uwsim ", "COMP_CWORD": "1"}
    assert set(uwsim_process(env=os.environ | asked).stdout.split()) == set(listed)


@pytest.mark.parametrize(("group", "default"), DEFAULTS.items())
def test_the_first_word_of_a_group_goes_to_its_default(group: str, default: str) -> None:
    assert parsed([group, "a"]) == parsed([group, default, "a"])
    assert parsed([group, "a"])[0] == f"uwsim {group} {default}" and "a" in map(str, parsed([group, "a"])[1].values())
    of_default = PROGRAM.commands[group].commands[default]
    shown = uwsim(group, "--help").stdout
    assert shown.startswith(f"Usage: uwsim {group} [OPTIONS]")
    assert all(option in shown for each in of_default.params for option in each.opts if option[0] == "-")
    assert all(f"\n  {name} " in shown for name in PROGRAM.commands[group].commands)


def test_options_go_to_the_default_too() -> None:
    assert parsed(["vehicle", "--json", "rov"]) == parsed(["vehicle", "report", "rov", "--json"])
    assert parsed(["exercise"]) == parsed(["exercise", "fly"])


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("recording dif", "'uwsim recording diff'"),
        ("exercise chek", "'uwsim exercise check'"),
        ("scenario rayz", "'rays'"),
        ("ros docter", "'doctor'"),
    ],
)
def test_a_mistyped_subcommand_is_suggested(words: str, meant: str) -> None:
    assert re.search(f"[Dd]id you mean {meant}", error_line(uwsim(*words.split())))


def test_a_mistyped_vehicle_stays_one() -> None:
    error = error_line(uwsim("vehicle", "rovv"))
    assert error.startswith("uwsim: error: unknown vehicle 'rovv'") and error.endswith("did you mean 'rov'?")
    assert uwsim("vehicle", "tun").stderr.splitlines()[-1] == "uwsim: did you mean 'uwsim vehicle tune'?"
    assert "did you mean" not in uwsim("recording", "a").stderr


def test_the_first_word_of_a_group_is_completed() -> None:
    def offered(line: str) -> set[str]:
        asked = {"_UWSIM_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(line.count(" "))}
        return set(uwsim_process(env=os.environ | asked).stdout.split())

    assert offered("uwsim vehicle ") >= {"report", "tune", "decompose", "identify", "rov", "remus100"}
    assert offered("uwsim vehicle --dr") == offered("uwsim vehicle rov --dr") == {"--draft"}
