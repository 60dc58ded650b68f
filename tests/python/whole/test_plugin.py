"""A package of others, tests/plugin, adds a command and a bridge by its entry points alone."""

import json
import signal
import socket
import subprocess
from pathlib import Path

import pytest

from command_line import UWSIM, error_line, uwsim_in_another_process, uwsim_process
from plugin_package import add_package, with_plugins

MISFITS = """
from dataclasses import dataclass
from uwsim.base.options import Options, option
from uwsim.bridges.plug import BridgePlug

class NoPlug: pass

@dataclass(frozen=True)
class OtherSwitch(Options):
    switch = "other"
    other: bool = option(False, "")

class OfAnother(BridgePlug[OtherSwitch]):
    options = OtherSwitch

@dataclass(frozen=True)
class OddName(Options):
    switch = "odd"
    odd: bool = option(False, "")
    speed: bool = option(False, "")

class Odd(BridgePlug[OddName]):
    options = OddName
"""
MISTAKES = [
    (["--toy-channel", "odom"], 2, "--toy-channel: needs --toy"),
    (["--toy", "127.0.0.1:9", "--toy-max", "99"], 2, "--toy-max = 99 bytes: must be in [100, 65000] bytes"),
    (["--toy", "nowhere"], 1, "--toy = 'nowhere': must be HOST:PORT"),
    (["--toy", "127.0.0.1:9", "--toy-channel", "odo"], 1, "--toy-channel = 'odo': must be one of"),
]
COMMANDS = [
    "--help", "toy --help", "toy pool", "serve --help", "replay --help", "ros doctor --help",
    "ros doctor --listen 0.1 --toy-max 5000", *(f"serve pool --port 0 {' '.join(words)}" for words, _, _ in MISTAKES),
]  # fmt: skip


@pytest.fixture(scope="module")
def ran(plugins: Path) -> dict[str, subprocess.CompletedProcess[str]]:
    """The results of COMMANDS, all in one process in which the package is installed."""
    results = uwsim_in_another_process(*(words.split() for words in COMMANDS), env=with_plugins(plugins))
    return dict(zip(COMMANDS, results, strict=True))


def test_a_command_is_listed_explained_completed_and_run(
    ran: dict[str, subprocess.CompletedProcess[str]], plugins: Path
) -> None:
    listed = ran["--help"]
    assert listed.stderr == ""
    assert "From other packages:\n  toy        List the sensors of each vehicle of a scenario.\n" in listed.stdout
    assert "Name of a scenario" in ran["toy --help"].stdout
    assert "rov: imu" in ran["toy pool"].stdout
    completing = {"_UWSIM_COMPLETE": "complete_bash", "COMP_WORDS": "uwsim to", "COMP_CWORD": "1"}
    assert uwsim_process(env=with_plugins(plugins) | completing).stdout.split() == ["toy"]


RULES = {
    "none": ("NoPlug", "must be a class derived from BridgePlug"),
    "mine": ("OfAnother", "switch = 'other': must be 'mine'"),
    "odd": ("Odd", "option speed: its name must"),
}


def test_a_broken_or_clashing_package_costs_a_line_of_warning(plugins: Path, tmp_path: Path) -> None:
    entries = ("gone = no_such_module:run", "survey = json:loads", "noise = math:pi")
    add_package(tmp_path, "bad_one", "uwsim.cli", *entries)
    (tmp_path / "misfit.py").write_text(MISFITS)
    bridges = [f"{name} = misfit:{each}" for name, (each, _) in RULES.items()]
    add_package(tmp_path, "misfit", "uwsim.bridges", *bridges)
    listed, toy, refused, shown = uwsim_in_another_process(
        ["--help"], ["toy"], ["gone"], ["serve", "--help"], env=with_plugins(plugins, tmp_path)
    )
    assert listed.returncode == 0
    assert listed.stderr.splitlines() == [
        "uwsim: warning: uwsim.cli: 'survey' of bad-one: the name is taken by uwsim",
        "uwsim: warning: uwsim.cli: 'gone' of bad-one (no_such_module:run): cannot be used: ModuleNotFoundError: No "
        "module named 'no_such_module'",
        "uwsim: warning: uwsim.cli: 'noise' of bad-one (math:pi): cannot be used: TypeError: float: must be a function "
        "or a typer.Typer",
    ]
    assert "  toy " in listed.stdout and "  survey " in listed.stdout and "noise" not in listed.stdout
    assert "rov: imu" in toy.stdout
    assert refused.returncode == 1
    assert "'gone' of bad-one (no_such_module:run): cannot be used" in refused.stderr.splitlines()[-1]
    assert "Traceback" not in refused.stderr

    assert "--ros2" in shown.stdout
    for line, (name, (each, rule)) in zip(sorted(shown.stderr.splitlines()), sorted(RULES.items()), strict=True):
        start = f"uwsim: warning: uwsim.bridges: '{name}' of misfit (misfit:{each}): cannot be used: "
        assert line.startswith(start) and rule in line
        assert f"--{name}" not in shown.stdout


def test_a_package_is_imported_only_by_its_own_command(tmp_path: Path) -> None:
    """Its module would end the process."""
    (tmp_path / "ending.py").write_text("raise SystemExit('imported')")
    environment = with_plugins(add_package(tmp_path, "ending", "uwsim.cli", "ending = ending:run"))
    other, own = uwsim_in_another_process(["scenario", "check", "pool"], ["ending"], env=environment)
    assert "pool.yaml: ok" in other.stdout
    assert "SystemExit: imported" in error_line(own)


def test_a_bridge_has_flags_in_every_command_of_bridges(ran: dict[str, subprocess.CompletedProcess[str]]) -> None:
    for words in ("serve --help", "replay --help"):
        assert all(flag in ran[words].stdout for flag in ("--toy HOST:PORT", "--toy-channel", "--toy-max"))
    assert "toy-max" in ran["ros doctor --help"].stdout
    assert "lines of 5000 bytes" in ran["ros doctor --listen 0.1 --toy-max 5000"].stdout


def test_a_mistake_in_its_options_gives_one_line(ran: dict[str, subprocess.CompletedProcess[str]]) -> None:
    for words, code, message in MISTAKES:
        done = ran[f"serve pool --port 0 {' '.join(words)}"]
        assert done.returncode == code
        assert message in error_line(done)


def test_its_bridge_sends_what_is_served_and_what_is_played(plugins: Path, tmp_path: Path) -> None:
    environment = with_plugins(plugins)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(600.0)
        toy = f"127.0.0.1:{listener.getsockname()[1]}"
        words = ["serve", "pool", "--port", "0", "--toy", toy, "--record", str(tmp_path / "run.mcap")]
        with subprocess.Popen([*UWSIM, *words], env=environment, stdout=subprocess.PIPE, text=True) as serving:
            try:
                assert serving.stdout is not None
                assert f"toy at {toy}" in serving.stdout.readline()
                first, second = (json.loads(listener.recv(1 << 16)) for _ in range(2))
            finally:
                serving.send_signal(signal.SIGTERM)
        assert serving.returncode == 0
        assert first["channel"] == "clock" and 0 <= first["time_ns"] < second["time_ns"]
        played = ["replay", str(tmp_path / "run.mcap"), "--as-topics", "--port", "0", "--toy", toy, "--speed", "100"]
        assert f"toy at {toy}" in uwsim_process(*played, env=environment).stdout
