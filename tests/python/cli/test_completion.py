"""Shell completions on Tab, requested through typer's own protocol, as bash, zsh and fish do."""

import os
import re
from pathlib import Path

import pytest

from command_line import UWSIM, uwsim_process


def asked(shell: str, line: str, cwd: Path) -> str:
    """Request completions as the shell function installed by `uwsim --install-completion` does."""
    protocol = {
        "bash": {"COMP_WORDS": line, "COMP_CWORD": str(line.count(" "))},
        "zsh": {"_TYPER_COMPLETE_ARGS": line},
        "fish": {"_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
    }[shell]
    answer = uwsim_process(env={**os.environ, **protocol, "_UWSIM_COMPLETE": f"complete_{shell}"}, cwd=cwd)
    assert answer.returncode == 0, answer.stderr
    return answer.stdout.strip()


def offered(shell: str, line: str, cwd: Path) -> list[str]:
    """Return the completions that the shell displays."""
    text = asked(shell, line, cwd)
    if shell == "zsh":
        return re.findall(r'\(?"([^"]*)"(?::"[^"]*")?', text)
    return [row.split("\t")[0] for row in text.splitlines()]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("uwsim map ", "build info convert from merge score render diff slice view film waterfall"),
        ("uwsim map sc", "score"),
        ("uwsim map slice --o", "--out --origin"),
        ("uwsim scenario schema s", "scenario sonar sensors"),
        ("uwsim survey po", "pool pole.yaml"),
        ("uwsim survey lake --link mi", "micromodem"),
    ],
)
def test_commands_options_and_values_are_offered(line: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "pole.yaml").touch()
    (tmp_path / "pole.txt").touch()
    for shell in ("bash", "zsh", "fish") if "po" in line or "--o" in line else ("bash",):
        assert set(offered(shell, line, tmp_path)) == set(expected.split()), shell


def test_the_shell_offers_files_where_nothing_fits(tmp_path: Path) -> None:
    for line in ("uwsim map info no", "uwsim survey no/such"):
        assert offered("bash", line, tmp_path) == []
        assert asked("zsh", line, tmp_path) == "_files"


def test_benchmarks_and_their_options_are_offered(tmp_path: Path) -> None:
    assert {"survey", "station"} <= set(offered("bash", "uwsim bench ", tmp_path))
    assert offered("bash", "uwsim bench survey --ru", tmp_path) == ["--runs"]
    assert offered("bash", "uwsim bench survey --js", tmp_path) == ["--json"]


def test_to_offer_imports_nothing_slow(tmp_path: Path) -> None:
    for line in ("uwsim map ", "uwsim bench survey --", "uwsim survey --seed 3 "):
        question = {"_UWSIM_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(line.count(" "))}
        command = [UWSIM[0], "-X", "importtime", *UWSIM[1:]]
        answer = uwsim_process(command=command, env=os.environ | question, cwd=tmp_path)
        assert answer.returncode == 0 and answer.stdout and "typer.main" in answer.stderr
        assert not re.search(r"\| +(numpy|pydantic|rich)$", answer.stderr, flags=re.MULTILINE)
