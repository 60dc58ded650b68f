"""An error in another package's code, when it is used, names the package, and ends only what asked for it."""

import subprocess
from pathlib import Path

import pytest

from command_line import uwsim_in_another_process
from plugin_package import with_plugins

PACKAGE = """
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

from uwsim.base.options import Options, option
from uwsim.bridges.plug import BridgePlug
from uwsim.channels import Channel, Service
from uwsim.scenario.spec.fault import FaultModel
from uwsim.scenario.spec.sensor_kind import DerivedKind

def raising(*arguments):
    raise LookupError("lost")

SENSOR = DerivedKind("lost", "nothing", "position", {"x": (1, "m")}, raising)

class Fault(FaultModel):
    kind: Literal["lost"]
    apply = raising

@dataclass(frozen=True)
class Asked(Options):
    switch = "lost"
    lost: bool = option(False, "")

class Plug(BridgePlug[Asked]):
    options = Asked

    @contextmanager
    def open(self, context):
        raising()
        yield

def topics(source):
    raising()

def unread(source):
    return [Channel("lost", "std_msgs/msg/String", "out", "", rate_hz=1.0, read=raising)]

def clashing(source):
    return [Service("release", "std_srvs/srv/Trigger", raising)]

def command():
    raising()

def mistaken():
    raise ValueError("a mistake of the user")
"""
ENTRIES = """
[uwsim.kinds.sensor]
lost = lost_package:SENSOR
[uwsim.kinds.fault]
lost = lost_package:Fault
[uwsim.bridges]
lost = lost_package:Plug
[uwsim.channels]
lost = lost_package:topics
unread = lost_package:unread
clashing = lost_package:clashing
[uwsim.cli]
lost = lost_package:command
mistaken = lost_package:mistaken
"""
SCENARIO = "name: lost\nterrain: {source: noise, size_m: [20, 20], bed_depth_m: 9}\n"
FAULT = SCENARIO + "vehicles: [{name: rov, model: rov}]\nfaults: [{kind: lost, at_s: 1}]\n"
SENSOR = SCENARIO + "vehicles: [{name: rov, model: lost_rov.yaml}]\n"
ROV = "name: lost_rov\nbuilds_on: rov\nsensors: {lost: {kind: lost, rate_hz: 10}}\n"
MISSION = "from uwsim.missions import wait\n\ndef mission(vehicle):\n    yield wait(1.0)\n"
USES = {
    ("lost",): "uwsim.cli: 'lost' of others (lost_package:command): command",
    ("serve", "pool", "--port", "0", "--lost"): "uwsim.bridges: 'lost' of others (lost_package:Plug): open",
    ("scenario", "check", "fault.yaml"): "uwsim.kinds.fault: 'lost' of others (lost_package:Fault): apply",
    (
        "run",
        "mission.py",
        "--scenario",
        "sensor.yaml",
    ): "uwsim.kinds.sensor: 'lost' of others (lost_package:SENSOR): measure",
}
FINE = (("mistaken",), ("run", "mission.py", "--scenario", "pool", "--report", "none", "--record", "lost.mcap"))
WARNED = (
    "uwsim.channels: 'lost' of others (lost_package:topics): cannot be used: LookupError: lost",
    "uwsim.channels: 'unread' of others (lost_package:unread): read of lost: LookupError: lost",
    "'clashing' of others (lost_package:clashing): cannot be used: ValueError: 'release': the name is taken",
)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, ...], subprocess.CompletedProcess[str]]:
    """The results of all commands, in one process in which the package is installed."""
    folder, work = tmp_path_factory.mktemp("others"), tmp_path_factory.mktemp("work")
    info = folder / "others-1.0.dist-info"
    info.mkdir()
    (info / "entry_points.txt").write_text(ENTRIES)
    (folder / "lost_package.py").write_text(PACKAGE)
    texts = {"fault.yaml": FAULT, "sensor.yaml": SENSOR, "lost_rov.yaml": ROV, "mission.py": MISSION}
    for name, text in texts.items():
        (work / name).write_text(text)
    commands = [*USES, *FINE]
    placed: list[list[str | Path]] = []
    for words in commands:
        out = ["--out", work / f"out{len(placed)}"] if words[0] == "run" else []
        placed.append([*(work / each if "." in each else each for each in words), *out])
    return dict(zip(commands, uwsim_in_another_process(*placed, env=with_plugins(folder)), strict=True))


@pytest.mark.parametrize("words", USES)
def test_an_error_names_package_entry_and_call(words: tuple[str, ...], results) -> None:
    done = results[words]
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert f"{USES[words]}: LookupError: lost" in done.stderr + done.stdout


def test_what_does_not_ask_for_it_works(results) -> None:
    mistaken, flown = (results[words] for words in FINE)
    assert (mistaken.returncode, mistaken.stderr) == (1, "uwsim: error: a mistake of the user\n")
    assert flown.returncode == 0 and all(line in flown.stderr for line in WARNED), flown.stderr
