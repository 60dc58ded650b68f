"""Shell completions on Tab, requested through typer's own protocol, as bash, zsh and fish do."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from command_line import UWSIM


def asked(shell: str, line: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Request completions as the shell function installed by `uwsim --install-completion` does."""
    words = line.split(" ")
    protocol = {
        "bash": {"COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)},
        "zsh": {"_TYPER_COMPLETE_ARGS": line},
        "fish": {"_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
    }[shell]
    environment = {**os.environ, **protocol, "_UWSIM_COMPLETE": f"complete_{shell}"}
    return subprocess.run(UWSIM, env=environment, cwd=cwd, capture_output=True, text=True, check=True, timeout=60)


def offered(shell: str, line: str, cwd: Path) -> list[str]:
    """Return the completions that the shell displays."""
    text = asked(shell, line, cwd).stdout.strip()
    return (
        re.findall(r'\(?"([^"]*)"(?::"[^"]*")?', text)
        if shell == "zsh"
        else [row.split("\t")[0] for row in text.splitlines()]
    )


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            "uwsim map ",
            {"build", "info", "convert", "from", "merge", "score", "render", "diff", "slice", "view", "film"}
            | {"waterfall"},
        ),
        ("uwsim map sc", {"score"}),
        ("uwsim scenario ", {"list", "new", "check", "schema", "from"}),
        ("uwsim map slice --o", {"--out", "--origin"}),
        ("uwsim scenario schema s", {"scenario", "sonar", "sensors"}),
        ("uwsim survey po", {"pool", "pole.yaml"}),
        ("uwsim survey lake --link mi", {"micromodem"}),
    ],
)
def test_commands_options_and_values_are_offered(shell: str, line: str, expected: set[str], tmp_path: Path) -> None:
    (tmp_path / "pole.yaml").touch()
    (tmp_path / "pole.txt").touch()
    assert set(offered(shell, line, tmp_path)) == expected


@pytest.mark.parametrize("line", ["uwsim map info no", "uwsim survey no/such"])
def test_the_shell_offers_files_where_nothing_fits(line: str, tmp_path: Path) -> None:
    assert offered("bash", line, tmp_path) == []
    assert asked("zsh", line, tmp_path).stdout.strip() == "_files"


def test_benchmarks_and_their_options_are_offered(tmp_path: Path) -> None:
    assert {"survey", "station"} <= set(offered("bash", "uwsim bench ", tmp_path))
    assert offered("bash", "uwsim bench survey --ru", tmp_path) == ["--runs"]
    assert offered("bash", "uwsim bench survey --js", tmp_path) == ["--json"]


def test_to_offer_imports_nothing_slow(tmp_path: Path) -> None:
    for line in ("uwsim map ", "uwsim bench survey --", "uwsim survey --seed 3 "):
        question = {"_UWSIM_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(line.count(" "))}
        command = [UWSIM[0], "-X", "importtime", *UWSIM[1:]]
        answer = subprocess.run(
            command, env=os.environ | question, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60
        )
        assert answer.stdout and "typer.main" in answer.stderr
        assert not re.search(r"\| +(numpy|pydantic|rich)$", answer.stderr, flags=re.MULTILINE)
