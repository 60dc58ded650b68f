"""A package of others, tests/plugin, adds a command and a bridge by its entry points alone."""

import json
import signal
import socket
import subprocess
from pathlib import Path

import pytest

from command_line import UWSIM, error_line, uwsim_in_another_process, uwsim_process
from plugin_package import add_package, installed_plugin, with_plugins

PLUG = """
from dataclasses import dataclass
from uwsim.base.options import Options, option
from uwsim.bridges.plug import BridgePlug

@dataclass(frozen=True)
class Mine(Options):
    switch = "{switch}"
    {name}: bool = option(False, "")

class Plug(BridgePlug[Mine]):
    options = Mine
"""


@pytest.fixture(scope="module")
def plugins(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return installed_plugin(tmp_path_factory.mktemp("plugins"))


def test_a_command_is_listed_explained_completed_and_run(plugins: Path) -> None:
    environment = with_plugins(plugins)
    listed, explained, run = uwsim_in_another_process(["--help"], ["toy", "--help"], ["toy", "pool"], env=environment)
    assert listed.stderr == ""
    assert "From other packages:\n  toy            List the sensors of each vehicle of a scenario.\n" in listed.stdout
    assert "Name of a scenario" in explained.stdout
    assert "rov: imu" in run.stdout
    completing = {"_UWSIM_COMPLETE": "complete_bash", "COMP_WORDS": "uwsim to", "COMP_CWORD": "1"}
    assert uwsim_process(env=environment | completing).stdout.split() == ["toy"]


def test_a_broken_or_clashing_package_costs_a_line_of_warning(plugins: Path, tmp_path: Path) -> None:
    broken = add_package(
        tmp_path, "bad_one", "uwsim.cli", "gone = no_such_module:run", "survey = json:loads", "noise = math:pi"
    )
    environment = with_plugins(plugins, broken)
    listed = uwsim_process("--help", env=environment)
    assert listed.returncode == 0
    assert listed.stderr.splitlines() == [
        "uwsim: warning: uwsim.cli: 'survey' of bad-one: the name is taken by uwsim",
        "uwsim: warning: uwsim.cli: 'gone' of bad-one (no_such_module:run): cannot be used: ModuleNotFoundError: No "
        "module named 'no_such_module'",
        "uwsim: warning: uwsim.cli: 'noise' of bad-one (math:pi): cannot be used: TypeError: float: must be a function "
        "or a typer.Typer",
    ]
    assert "  toy " in listed.stdout and "  survey " in listed.stdout and "noise" not in listed.stdout
    toy, refused = uwsim_in_another_process(["toy"], ["gone"], env=environment)
    assert "rov: imu" in toy.stdout
    assert refused.returncode == 1
    assert "'gone' of bad-one (no_such_module:run): cannot be used" in refused.stderr.splitlines()[-1]
    assert "Traceback" not in refused.stderr


def test_a_package_is_imported_only_by_its_own_command(tmp_path: Path) -> None:
    """Its module would end the process."""
    (tmp_path / "ending.py").write_text("raise SystemExit('imported')")
    environment = with_plugins(add_package(tmp_path, "ending", "uwsim.cli", "ending = ending:run"))
    assert "pool.yaml: ok" in uwsim_process("scenario", "check", "pool", env=environment).stdout
    assert "SystemExit: imported" in error_line(uwsim_process("ending", env=environment))


def test_a_bridge_has_flags_in_every_command_of_bridges(plugins: Path) -> None:
    environment = with_plugins(plugins)
    commands = [[command, "--help"] for command in ("serve", "replay", "doctor")]
    *served, doctor = uwsim_in_another_process(*commands, env=environment)
    for each in served:
        assert "--toy HOST:PORT" in each.stdout and "--toy-channel" in each.stdout and "--toy-max" in each.stdout
    assert "toy-max" in doctor.stdout


MISTAKES = [
    (["--toy-channel", "odom"], 2, "--toy-channel: needs --toy"),
    (["--toy", "127.0.0.1:9", "--toy-max", "99"], 2, "--toy-max = 99 bytes: must be in [100, 65000] bytes"),
    (["--toy", "nowhere"], 1, "--toy = 'nowhere': must be HOST:PORT"),
    (["--toy", "127.0.0.1:9", "--toy-channel", "odo"], 1, "--toy-channel = 'odo': must be one of"),
]


def test_a_mistake_in_its_options_gives_one_line(plugins: Path) -> None:
    commands = [["serve", "pool", "--port", "0", *arguments] for arguments, _, _ in MISTAKES]
    refused = uwsim_in_another_process(*commands, env=with_plugins(plugins))
    for done, (_, code, message) in zip(refused, MISTAKES, strict=True):
        assert done.returncode == code
        assert message in error_line(done)


def test_its_bridge_sends_what_is_served_and_what_is_played(plugins: Path, tmp_path: Path) -> None:
    environment = with_plugins(plugins)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(60.0)
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


def test_the_doctor_asks_its_bridge(plugins: Path) -> None:
    found = uwsim_process("doctor", "--listen", "0.1", "--toy-max", "5000", env=with_plugins(plugins)).stdout
    assert "lines of 5000 bytes" in found


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("class Plug: pass", "must be a class derived from BridgePlug"),
        (PLUG.format(switch="other", name="other"), "switch = 'other': must be 'mine'"),
        (PLUG.format(switch="mine", name="mine: bool = option(False, '')\n    speed"), "option speed: its name must"),
    ],
)
def test_a_bridge_that_does_not_fit_is_left_out_with_a_warning(text: str, rule: str, tmp_path: Path) -> None:
    (tmp_path / "misfit.py").write_text(text)
    environment = with_plugins(add_package(tmp_path, "misfit", "uwsim.bridges", "mine = misfit:Plug"))
    shown = uwsim_process("serve", "--help", env=environment)
    assert "--ros2" in shown.stdout and "--mine" not in shown.stdout
    (line,) = shown.stderr.splitlines()
    assert line.startswith("uwsim: warning: uwsim.bridges: 'mine' of misfit (misfit:Plug): cannot be used: ")
    assert rule in line
