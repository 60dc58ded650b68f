"""SECURITY.md's table of doors lists every socket on which a program receives, as the system counts them."""

import os
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from tools.reference.doors import PAGE, security_page

from listening_sockets import Socket, receiving
from ros1_tools import master, ros_is_installed
from ros2_tools import free_domain
from uwsim.bridges.doors import ANYWHERE, DOORS, LOOPBACK, Door

UWSIM = [sys.executable, "-c", "from uwsim.cli import main; main()"]
SERVE = next(door for door in DOORS if door.option.startswith("`serve`"))
PATIENCE_S = 60.0
HAS_FFMPEG = shutil.which("ffmpeg") is not None or find_spec("imageio_ffmpeg") is not None
NEEDS = {
    "`--mavlink tcp`": find_spec("pymavlink"), "`--mavlink udpin`": find_spec("pymavlink"),
    "`--mavlink udpout`": find_spec("pymavlink"), "`--ardusub-binary`": find_spec("pymavlink"),
    "`--video`": HAS_FFMPEG, "`--ros1`": ros_is_installed(),
    "`--ros2`": find_spec("cyclonedds"), "`--ros2 --rmw zenoh`, instead": find_spec("zenoh"),
}  # fmt: skip
OPTIONS = {
    "`--foxglove`": ["--foxglove", "--foxglove-port", "0"],
    "`--mavlink tcp`": ["--mavlink", "tcp:0"],
    "`--mavlink udpin`": ["--mavlink", "udpin:0"],
    "`--mavlink udpout`": ["--mavlink", "udpout"],
    "`--nmea tcp`": ["--nmea", "tcp:0"],
    "`--nmea udp`": ["--nmea", "udp"],
    "`--ardusub`": ["--ardusub", "--ardusub-port", "0"],
    "`--ardusub-binary`": ["--ardusub", "--ardusub-binary"],
    "`--video`": ["--video", "5600"],
    "`--ros1`": ["--ros1"],
    "`--ros2`": ["--ros2", "--rmw", "fastrtps"],
    "`--ros2 --rmw zenoh`, instead": ["--ros2", "--rmw", "zenoh"],
}
"""The options by which a program opens each door, in addition to that of `serve`."""
BESIDE = {"`--ardusub-binary`": ["`--ardusub`"]}
"""The other options' doors that these options open, too."""


def expected(doors: list[Door]) -> Counter[Socket]:
    """Return the number of sockets by protocol and address; by default, all but one kind are on loopback."""
    found: Counter[Socket] = Counter()
    for door in doors:
        found[door.protocol, ANYWHERE if door.address == ANYWHERE else LOOPBACK] += door.count
    return found


@pytest.fixture
def environment(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[dict[str, str]]:
    plain = {**os.environ, "ROS_DOMAIN_ID": str(free_domain())}
    if request.node.callspec.params["option"] != "`--ros1`":
        yield plain
        return
    with master(tmp_path) as ros:
        yield {**plain, **ros}


@pytest.mark.parametrize("option", [SERVE.option, *OPTIONS])
def test_the_sockets_of_a_program_are_those_of_the_table(
    option: str, environment: dict[str, str], binary: Path
) -> None:
    if not NEEDS.get(option, True):
        pytest.skip("not installed")
    opened = {option, *BESIDE.get(option, ())} - {SERVE.option}
    doors = [SERVE, *(door for door in DOORS if door.option in opened)]
    command = [*UWSIM, "serve", "lagoon", "--port", "0", *OPTIONS.get(option, [])]
    if option == "`--ardusub-binary`":
        command.append(str(binary))
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        try:
            assert process.stdout is not None and process.stdout.readline(), "it ended"
            end_s = time.monotonic() + PATIENCE_S
            while (found := receiving(process.pid)) != expected(doors) and time.monotonic() < end_s:
                time.sleep(0.2)
            assert found == expected(doors)
            time.sleep(1.0)
            assert receiving(process.pid) == expected(doors), "more were opened later"
        finally:
            process.terminate()


def test_every_door_is_opened_by_this_file() -> None:
    assert {door.option for door in DOORS} == {SERVE.option, *OPTIONS}


def test_the_table_in_security_md_is_the_present_one() -> None:
    assert PAGE.read_text() == security_page(), "run python -m tools.reference docs/reference"
