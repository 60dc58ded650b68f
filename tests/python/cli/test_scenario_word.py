"""Every command that takes a scenario takes it as a word and by --scenario."""

from collections.abc import Iterator
from typing import Any

import pytest
import typer

from uwsim.cli.bounds import UsageError
from uwsim.cli.program import app

FIRST = {"run": ["m.py"], "film": ["m.py"], "compare": ["frontier"], "ardusub": ["sub"],
         "ros connect": ["ws://host"], "map convert": ["a.bt", "b.ot"],
         "map score": ["a.bt"], "fleet": ["--tile", "8"], "replay": ["a"], "range": ["vision"],
         "scenario rays": ["--from=0,0,-1", "--to=1,1,-1"]}  # fmt: skip
"""The words before the scenario's."""


def commands() -> Iterator[tuple[str, Any]]:
    program = typer.main.get_command(app)
    for name in program.list_commands(None):  # type: ignore[attr-defined]
        if name != "bench":
            made = program.commands[name]  # type: ignore[attr-defined]
            yield from ((f"{name} {k}", each) for k, each in getattr(made, "commands", {name: made}).items())


TAKING = {name.split(" ")[0] if name.split(" ")[0] == name.split(" ")[-1] else name: each for name, each in commands()
          if any(parameter.name == "scenario" for parameter in each.params)}  # fmt: skip


def given(name: str, *words: str) -> Any:
    context = TAKING[name].make_context(name, list(words), resilient_parsing=False)
    return {key: value for key, value in context.params.items() if "scenario" in key or value in (words, list(words))}


@pytest.fixture(autouse=True)
def files(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("m.py", "a", "b", "sub", "a.bt", "b.ot"):
        (tmp_path / name).touch()


@pytest.mark.parametrize("name", TAKING)
def test_both_spellings_mean_the_same_and_one_is_enough(name: str) -> None:
    first = FIRST.get(name, [])
    assert given(name, *first, "pool") == given(name, *first, "--scenario", "pool")
    assert given(name, "--scenario=mine.yaml", *first) == given(name, *first, "mine.yaml")
    assert given(name, *first, "pool")["scenario"] == "pool"
    if name not in ("compare", "scenario parameters", "teleop"):  # where a further word has another meaning
        with pytest.raises(UsageError, match=r"--scenario lake, pool: one too many"):
            given(name, *first, "pool", "--scenario", "lake")


def test_the_commands_are_many_and_a_word_is_not_taken_for_one() -> None:
    assert TAKING.keys() >= {"survey", "run", "compare", "fleet", "dataset", "sonar", "camera", "serve", "station",
                             "teleop", "scenario link", "scenario parameters", "scenario fingerprint", "ros package",
                             *FIRST}  # fmt: skip
    context = TAKING["run"].make_context("run", ["m.py"])
    assert context.params["scenario"] is None and str(context.params["mission"]) == "m.py"
    assert TAKING["scenario parameters"].make_context("x", ["--scenario", "lake", "rov"]).params["prefix"] == "rov"
    assert TAKING["teleop"].make_context("x", ["ws://host:9090"]).params["scenario"] is None
    assert "[scenario]" in context.get_usage() and "--scenario" in TAKING["fleet"].get_help(context)
