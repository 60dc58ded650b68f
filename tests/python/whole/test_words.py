"""The word list for prose: no count may rise, and ceilings follow counts down."""

import pytest
from tools.words import AREAS, SLACK, WORDS, area_of, count_in, lowered, problems


def table(number: int) -> dict[str, dict[str, int]]:
    return {word: dict.fromkeys(AREAS, number) for word in WORDS}


def test_words_are_counted_whole_in_any_case_and_docstrings_by_their_first_word() -> None:
    found = count_in('"""What it Says: anew."""\n/// Of all.\n"""Return what is not said; essays."""\nwhat is no file')
    assert {word: number for word, number in found.items() if number} == {
        "says": 1,
        "anew": 1,
        "what is no": 1,
        "docstring What/Of/Who/Whether": 2,
    }


@pytest.mark.parametrize(
    ("name", "area"),
    [
        ("README.md", "docs"),
        ("docs/guides/live.md", "docs"),
        ("cpp/uwsim/core/parallel.h", "cpp"),
        ("tools/lint", "tools"),
        ("python/uwsim/operator/station/page/vendor/three.js", None),
        ("assets/scenarios/lake.yaml", None),
        ("tools/words.py", None),
    ],
)
def test_files_count_in_the_area_of_their_folder(name: str, area: str | None) -> None:
    assert area_of(name) == area


def test_a_count_above_its_ceiling_fails_and_an_update_does_not_raise_the_ceiling() -> None:
    assert len(problems(table(11), table(10))) == len(WORDS) * len(AREAS)
    assert lowered(table(11), table(10)) == table(10)


def test_a_count_below_its_ceiling_lowers_it_and_must_after_some() -> None:
    assert problems(table(10 - SLACK), table(10)) == []
    assert all("lower the ceiling" in line for line in problems(table(9 - SLACK), table(10)))
    assert lowered(table(3), table(10)) == table(3)
