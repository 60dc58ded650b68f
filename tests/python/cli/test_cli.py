"""The command line: one clear line for each user error, help texts with units, and the small commands."""

import json
import os
import re
from pathlib import Path
from typing import Any

import pytest
import typer

from command_line import error_line, uwsim
from docs_pages import page_named
from uwsim.cli.exit_codes import EXIT_CODES
from uwsim.cli.program import app
from uwsim.scenario.read.assets import assets_folder

CLOUD = str(Path(__file__).parents[1] / "data" / "pcl_binary.ply")
MESH = str(next((assets_folder() / "meshes").glob("*.obj")))
POOL_TERRAIN = "source: noise\n  size_m: [20, 20]\n  spacing_m: 0.5\n  bed_depth_m: 5"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["survey", "lakee"], "did you mean 'lake'"),
        (["survey", "\x1b[31mlake"], "\\x1b[31mlake"),  # would command a terminal
        (["survey", "no/such.yaml"], "no such file"),
        (["survey", "pool", "--sonar-model", "7"], "sonar.model"),
        (["scenario", "sonar", "pool", "--sonar-model", "em2040-9"], "unknown sonar 'em2040-9'"),
        (["scenario", "sonar", "pool", "--sonar-model", "em2040-07"], "frequency_hz: missing"),
        (["survey", "pool", "--frequency", "310"], "frequency_hz = 310000 Hz"),
        (["survey", "pool", "--mission-time", "-5"], "--mission-time = -5.0 s: must be in [1, 1000000] s"),
        (["survey", "pool", "--threads", "0"], "threads"),
        (["survey", "pool", "--frequency", "abc"], "--frequency = 'abc': must be a number in [0.1, 100000] kHz"),
        (["dataset", "pool", "--n", "2.5"], "--n = '2.5': must be a whole number in [1, 1000000]"),
        (["dataset", "--sequence", "cove-lane"], "did you mean 'cove-lanes'?"),
        (["dataset", "lake", "--sequence", "cove-lanes"], "SCENARIO: set by the sequence cove-lanes; leave it out"),
        (["bench", "surveyy"], "unknown"),
        (["survey", "pool", "--out", "/proc/uwsim"], "cannot write there"),
        (["survey", "pool", "--out", CLOUD], "pcl_binary.ply: is not a folder"),
        (["surveyy"], "No such command"),
        (["survey", "pool", "--out="], "--out is empty"),
        (["survey", ""], "an argument is empty"),
        (["station", "--no-browser", "--wire", "wired"], "wire = 'wired'"),
        (["station", "--no-browser", "--origin", "here"], "origin = 'here'"),
        (["vehicle", "decompose", MESH, "--out", "no/such/pieces.obj"], "cannot write into the folder 'no/such'"),
        (
            ["map", "convert", CLOUD, "cloud.ply", "--scenario", "lake"],
            "--scenario: needs a target that ends in .las, .laz, .xyz, .tif",
        ),
        (["reproduce", "--out", "/proc/self"], "/proc/self"),
        (["survey", "--voxl", "1"], "--voxl"),
        (["ros", "doctor", "--listen", "0.1", "--moos", "x" * 300], "the host a name or an IPv4 address"),
        (["ros", "doctor", "--listen", "0.1", "--imc", "%s"], "the host a name or an IPv4 address"),
        (["serve", "pool", "--namespace", "x" * 300], "at most 200"),
        (["serve", "pool", "--frame-prefix", "\x01"], "--frame-prefix"),
        (["vehicle", "remus100", "--out", "."], "is a folder: must be a file"),
        (["map", "score"], "source"),
        (["bench", "survey", "--voxl", "1"], "--voxl"),
    ],
)
def test_a_mistake_gives_one_line(arguments: list[str], expected: str, tmp_path: Path) -> None:
    assert expected in error_line(uwsim(*arguments, cwd=tmp_path))
    assert not any(tmp_path.iterdir()), "nothing partial is written"


def test_a_pipe_that_nobody_writes_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    for command in (
        ["sweep"],
        ["map", "info"],
        ["vehicle", "identify", "--vehicle", "rov"],
        ["scenario", "new", "mine", "--force", "--out"],
    ):
        said = error_line(uwsim(*command, str(tmp_path / "pipe.yaml")))
        assert "is a pipe" in said or "not a regular file" in said


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("sonar:", "sonr:", "did you mean 'sonar'"),
        ("bed_depth_m: 5", "bed_depth_m: .nan", "bed_depth_m"),
        (POOL_TERRAIN, "source: raster\n  file: missing.tif\n  water_level_m: 0", "missing.tif"),
        ("mission_time_s: 600", "mission_time_s: -600", "mission_time_s = -600"),
    ],
)
def test_a_mistake_in_the_yaml_is_named_with_its_line(old: str, new: str, expected: str, tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    assert old in text
    (tmp_path / "mine.yaml").write_text(text.replace(old, new, 1))
    line = error_line(uwsim("survey", str(tmp_path / "mine.yaml"), "--out", str(tmp_path / "out")))
    assert expected in line and "mine.yaml:" in line
    assert not (tmp_path / "out").exists()


def test_no_line_of_help_is_cut_and_units_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    for command in ([], ["map"], ["scenario"]):
        assert "..." not in uwsim(*command, "--help").stdout.replace("COMMAND [ARGS]...", "")
    for command in (["survey"], ["bench", "survey"]):
        shown = uwsim(*command, "--help").stdout
        assert "[m]" in shown and f"uwsim {' '.join(command)}" in shown


def test_each_command_is_listed_once_under_a_heading() -> None:
    sections = re.findall(r"^([A-Z][\w ]+):\n((?:  .*\n)+)", uwsim("--help").stdout, flags=re.MULTILINE)
    by_heading = {
        heading: re.findall(r"^  ([a-z][\w-]*)", lines, flags=re.MULTILINE)
        for heading, lines in sections
        if heading not in ("Options", "Exit codes")
    }
    program: Any = typer.main.get_command(app)
    assert sorted(name for names in by_heading.values() for name in names) == sorted(program.commands)
    assert "Commands" not in by_heading, "a command has no heading"
    assert by_heading["Fly"][:2] == ["survey", "run"]


def test_every_exit_code_is_in_the_help_and_in_the_documentation() -> None:
    shown, page = uwsim("--help").stdout, page_named("conventions").read_text()
    for code, meaning in EXIT_CODES.items():
        assert f"{code}  {meaning}" in shown
        assert f"| {code} | {meaning} |" in page


def test_scenarios_are_listed_and_described() -> None:
    listed = uwsim("scenario", "list")
    assert listed.returncode == 0
    assert all(f"{name}:" in listed.stdout for name in ("lake", "valley", "pool"))
    by_name = {each["name"]: each for each in json.loads(uwsim("scenario", "list", "--json").stdout)}
    assert {"lake", "valley"} < set(by_name) and by_name["pool"]["vehicles"] == {"rov": "rov"}
    assert "pool.yaml: ok" in uwsim("scenario", "check", "pool").stdout
    assert "uwsim scenario check pool" in error_line(uwsim("scenario", "pool"))


def test_the_survey_benchmark_prints_where_the_time_goes(tmp_path: Path) -> None:
    assert "survey" in uwsim("bench").stdout
    results = tmp_path / "results.json"
    results.write_text("of another program")
    refused = uwsim("bench", "survey", "pool", "--json", str(results))
    assert "uwsim did not write it" in error_line(refused) and results.read_text() == "of another program"
    results.unlink()
    result = uwsim("bench", "survey", "pool", "--runs", "1", "--mission-time", "3", "--json", str(results))
    assert result.returncode == 0, result.stderr
    for stage in ("physics", "rays", "codec", "conversion", "map"):
        assert stage in result.stdout and f"{stage}_s" in results.read_text()
