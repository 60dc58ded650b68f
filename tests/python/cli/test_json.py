"""--json: every command that prints results has it; the others are listed with where their results are."""

import json
from collections.abc import Iterator

import pytest
import typer

from command_line import uwsim
from uwsim.cli.program import app
from uwsim.exercises import exercise_names

ELSEWHERE = {
    "summary.json of --out": ["survey", "run", "fleet"],
    "compare.json of --out": ["compare"],
    "runs.parquet of --out": ["sweep"],
    "dataset.json of --out": ["dataset"],
    "figures.json of --out": ["reproduce"],
    "the file or the pictures that it writes": [
        "scenario sonar", "scenario camera", "recording film", "vehicle decompose",
        "ros package", "scenario new", "scenario from",
        "scenario plan", "course new", "course world", "course bag",
        "course table", "map convert", "map merge", "map render",
        "map slice", "map build", "map from", "map film", "map waterfall",
    ],
    "a server or a vehicle, until Ctrl-C": [
        "serve", "station", "teleop", "ardusub", "ros connect", "map view",
    ],
    "it prints nothing but JSON": ["scenario schema"],
    "only subcommands": ["course", "ros", "scenario", "map", "bench"],
}  # fmt: skip


def commands(group, path: tuple[str, ...] = ()) -> Iterator[tuple[str, set[str]]]:
    """Yield the words and the options of each command, and of each group that can be called without one."""
    context = typer.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        is_group = hasattr(command, "list_commands")
        if is_group:
            yield from commands(command, (*path, name))
        if not is_group or command.invoke_without_command:
            yield " ".join((*path, name)), {word for each in command.params for word in each.opts}


def test_every_command_prints_json_or_has_its_results_elsewhere():
    elsewhere = {name for names in ELSEWHERE.values() for name in names}
    found = dict(commands(typer.main.get_command(app)))
    assert len(found) > 50
    assert {name for name, options in found.items() if "--json" not in options} == elsewhere


@pytest.mark.parametrize("words", ["exercise", "scenario list", "scenario parameters pool", "ros doctor"])
def test_what_is_listed_is_json(words: str):
    listed = uwsim(*words.split(), "--json")
    assert listed.stdout, listed.stderr
    found = json.loads(listed.stdout)
    assert isinstance(found, list | dict)
    if words == "exercise":
        assert [each["name"] for each in found] == exercise_names()
