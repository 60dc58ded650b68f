"""A broken package costs a warning that names it: whatever its group, every command works as without it."""

import os
import subprocess
import tomllib
from pathlib import Path
from unittest import mock

import pytest

from command_line import uwsim, uwsim_in_another_process
from docs_pages import ROOT
from plugin_package import with_plugins

OWN = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
WAYS = {"gone": "no_such_module:f", "seven": "others_of_all:SEVEN", "raising": "others_of_all:raising"}
"""Entries by name: the module cannot be imported, the object is of the wrong type, and the module raises an error."""
FOLDERS = ("flown", "compared")
FLIGHT = "survey cast.yaml --time-limit 1 --report none --out flown --record flown.mcap --record-topic scan"
LISTING = {  # a command that goes over all entries of a group; the first one makes a map
    **dict.fromkeys(("uwsim.attachments", "uwsim.channels", "uwsim.kinds.cast"), FLIGHT),
    "uwsim.assets": "scenario check unknown",
    "uwsim.cli": "--help",
    **{f"uwsim.cli.{name}": f"{name} --help" for name in ("map", "scenario", "recording")},
    "uwsim.kinds.flight_log": "vehicle identify empty.txt --vehicle rov",
    "uwsim.kinds.mission_file": "run empty.txt",
    "uwsim.scenario_sources": "scenario from empty.txt",
    "uwsim.schemas": "scenario schema exercise",
    "uwsim.bridges": "serve --help",
    "uwsim.autopilots": "serve --help",
    "uwsim.flights": "run --help",
    "uwsim.pages": "serve --help",
    "uwsim.kinds.cloud_file": "map convert flown/map.bt cloud.xyz",
    **{f"uwsim.kinds.{part}": f"scenario schema {part}" for part in
       ("fault", "imaging_sonar", "obstacle", "cover", "life", "terrain", "sensor")},
    "uwsim.kinds.material": "scenario schema obstacle",
    "uwsim.kinds.thrust": "scenario schema thruster",
    "uwsim.kinds.goal": "scenario schema exercise",
}  # fmt: skip
NAMED = {  # a command that uses one entry of a group
    "uwsim.cli": "{}",
    "uwsim.cli.scenario": "scenario {}",
    "uwsim.schemas": "scenario schema {}",
    "uwsim.kinds.map_file": "map info empty.{}",
    "uwsim.kinds.cloud_file": "map convert flown/map.bt cloud.{}",
    "uwsim.kinds.grid_file": "map convert flown/map.bt grid.{}",
    "uwsim.kinds.survey_file": "map convert empty.{} cloud.xyz",
    "uwsim.kinds.planner": "compare {} --scenario pool --seeds 1 --out compared",
}
WITHOUT_NAMES = {"uwsim.step_sources"}
"""Groups of which uwsim asks for its own entries only."""


def named(group: str) -> dict[str, str]:
    """Return the broken entries of a group by name, which no other group has."""
    return {f"{way}_{group.split('.')[-1]}": value for way, value in WAYS.items()}


Results = dict[tuple[str, ...], subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Results]:
    """The results of all commands, without and with a package that is broken in every group."""
    folder = tmp_path_factory.mktemp("broken")
    lines = []
    for group, own in OWN.items():
        lines += [f"[{group}]", *(f"{name} = {value}" for name, value in named(group).items())]
        lines += [f"{next(iter(own))} = others_of_all:SEVEN"]
    info = folder / "others-1.0.dist-info"
    info.mkdir()
    (info / "entry_points.txt").write_text("\n".join(lines))
    (folder / "others_of_all.py").write_text(
        'SEVEN = 7\ndef __getattr__(name):\n    raise LookupError(f"{name}: lost")\n'
    )
    commands = list(dict.fromkeys(tuple(text.split()) for text in LISTING.values()))
    of_one = [tuple(text.format(name).split()) for group, text in NAMED.items() for name in named(group)]

    def run(commands: list[tuple[str, ...]], *folders: Path) -> Results:
        work = tmp_path_factory.mktemp("work")
        (work / "empty.txt").touch()
        before, _, after = (ROOT / "assets/scenarios/pool.yaml").read_text().partition("  density_kg_m3")
        cast = "  profile: {kind: table, file: cast.txt, temperature_deg_c: 15}\n" + after[after.index("terrain:") :]
        (work / "cast.yaml").write_text(before + cast)
        (work / "cast.txt").write_text("0 1480\n5 1481\n")
        for name in (*named("uwsim.kinds.map_file"), *named("uwsim.kinds.survey_file")):
            (work / f"empty.{name}").touch()
        placed = [
            [str(work / each) if "." in each or each in FOLDERS else each for each in words] for words in commands
        ]
        env = with_plugins(*folders)
        with mock.patch.dict(os.environ, env):
            done = uwsim_in_another_process(*placed, env=env) if folders else [uwsim(*words) for words in placed]
        return {words: _relative(each, work) for words, each in zip(commands, done, strict=True)}

    return run(commands), run([*commands, *of_one], folder)


def _relative(done: subprocess.CompletedProcess[str], work: Path) -> subprocess.CompletedProcess[str]:
    """Return what a command returned without the folder in which it ran."""
    return subprocess.CompletedProcess(
        done.args, done.returncode, done.stdout.replace(str(work), ""), done.stderr.replace(str(work), "")
    )


def test_the_tables_cover_every_group() -> None:
    assert set(LISTING) | set(NAMED) | WITHOUT_NAMES == set(OWN)


@pytest.mark.parametrize("group", LISTING)
def test_commands_work_as_without_a_broken_package(group: str, results: tuple[Results, Results]) -> None:
    words = tuple(LISTING[group].split())
    without, broken = (each[words] for each in results)
    assert broken.returncode == without.returncode
    if LISTING[group] != FLIGHT:  # whose table has the time that it took
        assert broken.stdout == without.stdout


@pytest.mark.parametrize("group", sorted(OWN.keys() - WITHOUT_NAMES))
def test_each_broken_entry_is_reported_with_its_package(group: str, results: tuple[Results, Results]) -> None:
    """A warning where all are listed; the one line of the error where the entry is asked for by its name."""
    _, broken = results
    if group in LISTING:
        said = "\n".join(each.stderr for each in broken.values())
        for name, value in named(group).items():
            assert f"uwsim: warning: {group}: '{name}' of others ({value}): " in said
    for name, value in named(group).items() if group in NAMED else ():
        done = broken[tuple(NAMED[group].format(name).split())]
        *_, line = done.stderr.splitlines()
        assert done.returncode and "Traceback" not in done.stderr
        known = group == "uwsim.schemas"  # of which only those that can be used are known
        start = f"part = '{name}': must be one of" if known else f"{group}: '{name}' of others ({value}): "
        assert line.startswith(f"uwsim: error: {start}")


@pytest.mark.parametrize("group", sorted(OWN.keys() - WITHOUT_NAMES))
def test_a_name_that_is_taken_stays_uwsims(group: str, results: tuple[Results, Results]) -> None:
    said = "\n".join(each.stderr for each in results[1].values())
    assert f"uwsim: warning: {group}: '{next(iter(OWN[group]))}' of others: the name is taken by uwsim" in said
