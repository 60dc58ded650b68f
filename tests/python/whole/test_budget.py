"""The budget: no count may exceed its number, and numbers follow the counts down."""

import subprocess
from pathlib import Path

import pytest
from tools import budget

AUTHOR = ["-c", "user.name=a", "-c", "user.email=a@b.c"]


def table(number: float) -> dict[str, dict[str, float]]:
    return {name: {"a": number, "b": number} for name in budget.SLACK}


@pytest.mark.parametrize(("name", "room"), [
    ("README.md", "docs"), ("docs/guides/live.md", "docs"), ("docs/reference/cli.md", None),
    ("cpp/uwsim/core/parallel.h", "cpp/uwsim/core"), ("cpp/bindings/sim/bind_ping.cpp", "cpp/bindings"),
    ("python/uwsim/operator/station/server.py", "python/uwsim/operator"),
    ("python/uwsim/__init__.py", "python/uwsim"), ("python/uwsim/operator/station/page/vendor/three.js", None),
    ("tests/python/browser.py", "tests/python"), ("tests/python/mapping/test_clouds.py", "tests/python/mapping"),
    ("tests/fuzz/readers.py", "tests/fuzz"), ("tools/lint", "tools"),
])  # fmt: skip
def test_a_file_counts_in_its_room(name: str, room: str | None) -> None:
    assert budget.room_of(name) == room


def test_a_count_above_its_number_fails_and_an_update_does_not_raise_the_number() -> None:
    assert len(budget.problems(table(11), table(10))) == 2 * len(budget.SLACK)
    assert budget.lowered(table(11), table(10)) == table(10)


def test_a_room_without_a_number_may_hold_nothing() -> None:
    assert budget.problems({"lines": {"a": 1, "new": 1}}, {"lines": {"a": 1}}) == [
        "budget: lines of 'new': 1, at most 0: remove some"
    ]


def test_a_commit_that_holds_more_than_its_numbers_or_raises_that_of_all_is_named(tmp_path: Path) -> None:
    def commit(lines: int, most: int, of_all: int) -> str:
        (tmp_path / "tools").mkdir(exist_ok=True)
        (tmp_path / "tools/a.py").write_text("x\n" * lines)
        (tmp_path / "tools/budget.toml").write_text(f'[lines]\n"all" = {of_all}\n"tools" = {most}\n')
        for words in (["init", "-q"], ["add", "."], [*AUTHOR, "commit", "-q", "-m", f"{lines} of {most}, {of_all}"]):
            subprocess.run(["git", *words], cwd=tmp_path, check=True)
        return subprocess.run(["git", "rev-parse", "HEAD"], cwd=tmp_path, capture_output=True, text=True).stdout.strip()

    first = commit(10, 25, 40)
    for row in ((15, 25, 40), (18, 25, 35), (16, 25, 36), (16, 17, 35), (9, 17, 30)):
        commit(*row)
    found = list(budget.broken_commits(tmp_path, first))
    assert [line.partition(": ")[2].partition(" ")[2] for line in found] == [
        "16 of 25, 36: the number of all lines is raised from 35 to 36",
        "16 of 17, 35: 'tools' 19 of 17",
    ]


@pytest.mark.parametrize(("name", "slack"), budget.SLACK.items())
def test_a_number_follows_its_count_down(name: str, slack: int) -> None:
    most = {name: {"a": slack + 10}}
    assert budget.problems({name: {"a": 10}}, most) == []
    assert [line.endswith("--update") for line in budget.problems({name: {"a": 9}}, most)] == [True]
    step = budget.STEP.get(name, 1)
    assert budget.lowered({name: {"a": 0}}, most) == {name: {"a": 0}}
    assert budget.lowered({name: {"a": 9}}, {name: {"a": 99}}) == {name: {"a": 9 if step == 1 else max(10, step)}}


def test_words_are_found_whole_in_any_case_and_docstrings_by_their_first_word() -> None:
    text = '"""What it Says: anew."""\n/// Of all.\n"""Return what is not said; essays."""\nwhat is no file'
    found = {word: len(pattern.findall(text)) for word, pattern in budget.PATTERNS.items()}
    expected = {"says": 1, "anew": 1, "what is no": 1, "docstring What/Of/Who/Whether": 2}
    assert {word: number for word, number in found.items() if number} == expected


def test_the_numbers_are_written_as_they_are_read() -> None:
    text = budget.NUMBERS.read_text()
    assert budget.written(budget.tomllib.loads(text)) == text
