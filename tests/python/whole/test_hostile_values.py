"""Numeric inputs are bounded, in files and on the command line; hostile values are refused in one line."""

import math
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.hostile.lines import BASES, commands

from command_line import error_line, uwsim
from uwsim.base import atomic_file
from uwsim.campaigns.sweeps.spec import SweepSpec
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.read.validated import validated
from uwsim.scenario.schema import PARTS

ROOT = Path(__file__).parents[3]

HOSTILE = [
    math.nan,
    math.inf,
    -math.inf,
    1e308,
    -1e308,
    1e-308,
    0,
    -1,
    2**63,
    -(2**64),
    10**400,
    True,
    "1",
    None,
    [],
    {},
]


def unbounded(node: Any, where: str) -> Iterator[str]:
    """Yield the numbers in a JSON Schema that lack a bound."""
    if isinstance(node, dict):
        is_number = node.get("type") in ("number", "integer") and not {"enum", "const"} & node.keys()
        has_bounds = all({name, f"exclusive{name.title()}"} & node.keys() for name in ("minimum", "maximum"))
        if is_number and not has_bounds:
            yield where
        for key, part in node.items():
            if key not in ("default", "examples", "description"):
                yield from unbounded(part, f"{where}.{key}")
    elif isinstance(node, list):
        for number, part in enumerate(node):
            yield from unbounded(part, f"{where}[{number}]")


def test_every_number_of_a_scenario_and_of_a_sweep_has_bounds() -> None:
    from pydantic import TypeAdapter

    found = [each for part, kind in PARTS.items() for each in unbounded(TypeAdapter(kind).json_schema(), part)]
    assert not [*found, *unbounded(SweepSpec.model_json_schema(), "sweep")]


def test_a_number_without_bounds_would_be_found() -> None:
    assert list(unbounded({"properties": {"mass_kg": {"type": "number", "minimum": 0}}}, "")) == [".properties.mass_kg"]


@pytest.mark.parametrize("command", sorted(BASES))
def test_every_number_on_a_command_line_has_bounds(command: str) -> None:
    for parameter in commands()[command]:
        if parameter.kind in (int, float):
            low, high, _ = parameter.bounds.bounds
            assert math.isfinite(low) and math.isfinite(high), parameter.name


@pytest.mark.parametrize("words", ["validate dynamics sona", "survey --engine brick", "scenario camera --jerlov 4C"])
def test_a_word_that_is_none_is_a_wrong_command_line(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = uwsim(*words.split())
    assert done.returncode == 2
    assert re.fullmatch(r"uwsim: error: (--)?\w+ = '\w+': must be one of .*", error_line(done))
    assert not list(tmp_path.iterdir())


def test_every_command_is_attacked() -> None:
    assert commands().keys() == BASES.keys()


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the paths of the numbers in nested values."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list | tuple) else ()
    for key, part in items:
        yield from leaves(part, (*path, key))
    if isinstance(value, int | float) and not isinstance(value, bool):
        yield path


def replaced(value: Any, path: tuple[Any, ...], leaf: Any) -> Any:
    if not path:
        return leaf
    copy = dict(value) if isinstance(value, dict) else list(value)
    copy[path[0]] = replaced(value[path[0]], path[1:], leaf)
    return copy


LAKE = load("lake").model_dump()
PLACES = sorted(leaves(LAKE), key=str)


@settings(max_examples=60)
@given(place=st.sampled_from(PLACES), value=st.sampled_from(HOSTILE) | st.floats() | st.integers())
def test_a_hostile_value_anywhere_is_refused_or_within_bounds(place: tuple[Any, ...], value: Any) -> None:
    try:
        read = validated(Scenario, replaced(LAKE, place, value))
    except ScenarioError as error:
        assert all(str(error).splitlines()), "it says which, and why"
        return
    assert not isinstance(value, float) or math.isfinite(value), f"{place}: {value} was accepted"
    assert isinstance(read, Scenario)


def test_a_process_that_ends_at_once_leaves_no_temporary_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left: list[Path] = []

    def ended(self: Path, target: Path) -> Path:
        assert self.is_file()
        atomic_file.remove_unfinished()
        left.extend(tmp_path.iterdir())
        raise OSError("ended")

    monkeypatch.setattr(Path, "replace", ended)
    with pytest.raises(OSError, match="ended"):
        atomic_file.write_atomically(tmp_path / "picture.png", b"content")
    assert not left


def test_hostile_command_lines_end_as_they_should() -> None:
    """A fixed selection from `tools/hostile`."""
    command = [sys.executable, "-m", "tests.hostile", "--only", "map ", "--sample", "6"]
    attacked = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert attacked.returncode == 0, attacked.stdout + attacked.stderr
    assert "6 lines, 0 broke the law" in attacked.stdout
