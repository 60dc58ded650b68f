"""SECURITY.md's table of doors lists every socket on which a program receives, as the system counts them."""

import os
import re
import shutil
import socket
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
from uwsim.base.options import flag_name
from uwsim.bridges.door import ANYWHERE, LOOPBACK, Door
from uwsim.bridges.doors import SERVE, doors
from uwsim.bridges.page import Pages
from uwsim.bridges.requested import Bridges, offered
from uwsim.cli.autopilots import Autopilots

UWSIM = [sys.executable, "-c", "from uwsim.cli import main; main()"]
LAGOON = Path(__file__).parents[3] / "assets/scenarios/lagoon.yaml"
PATIENCE_S = 60.0
HAS_FFMPEG = shutil.which("ffmpeg") is not None or find_spec("imageio_ffmpeg") is not None
NEEDS = {
    "`--mavlink tcp`": find_spec("pymavlink"), "`--mavlink udpin`": find_spec("pymavlink"),
    "`--mavlink udpout`": find_spec("pymavlink"), "`--ardusub-binary`": find_spec("pymavlink"),
    "`--video`": HAS_FFMPEG, "`--ros1`": ros_is_installed(),
    "`--ros2`": find_spec("cyclonedds"), "`--ros2 --rmw zenoh`, instead": find_spec("zenoh"),
}  # fmt: skip
DOORS = doors()
PAGES = {f"`{flag_name(name)}`": (flag_name(name),) for name in Pages.offered()}
EXAMPLES = {door.option: door.example for door in DOORS} | PAGES
"""The options by which a program opens each door, in addition to that of `serve`; a page has none of its own."""
TOGETHER = (
    ("`serve`, `station`, `replay --as-topics`, `exercise --serve`",),
    (
        "`--station`", "`--ros2`", "`--ros1`", "`--foxglove`", "`--video`", "`--mavlink tcp`", "`--nmea tcp`",
        "`--imc tcp`", "`--moos`",
    ),
    ("`--ros2 --rmw zenoh`, instead", "`--mavlink udpin`", "`--nmea udp`", "`--imc udp`"),
    ("`--mavlink udpout`", "`--imc announce`"),
    ("`--ardusub`",),
    ("`--ardusub-binary`",),
)  # fmt: skip
"""The options that one program is given: a process for each would take half a minute of processor time more."""
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
    if "`--ros1`" not in request.node.callspec.params["options"] or not ros_is_installed():
        yield plain
        return
    with master(tmp_path) as ros:
        yield {**plain, **ros}


@pytest.fixture
def lagoon(tmp_path: Path) -> Path:
    """A scenario with a place on Earth, which some bridges need."""
    path = tmp_path / "lagoon.yaml"
    path.write_text(f"{LAGOON.read_text()}\nearth: {{latitude_deg: 43.8, longitude_deg: -70.3}}\n")
    return path


def test_each_option_is_given_to_one_program() -> None:
    assert Counter(option for options in TOGETHER for option in options) == Counter(list(EXAMPLES))


@pytest.mark.parametrize("options", TOGETHER, ids=lambda options: options[0])
def test_the_sockets_of_a_program_are_those_of_the_table(
    options: tuple[str, ...], environment: dict[str, str], binary: Path, lagoon: Path
) -> None:
    missing = [option for option in options if not NEEDS.get(option, True)]
    given = [option for option in options if option not in missing]
    if not given:
        pytest.skip(f"not installed: {', '.join(missing)}")
    opened = {*given, *(other for option in given for other in BESIDE.get(option, ()))} - {SERVE.option}
    doors = [SERVE, *(door for door in DOORS if door.option in opened)]
    with socket.socket(type=socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    example = [word.replace("{port}", port) for option in given for word in EXAMPLES[option]]
    command = [*UWSIM, "serve", str(lagoon), "--port", "0", *example]
    if "`--ardusub-binary`" in given:
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
    if missing:
        pytest.skip(f"the others were tried; not installed: {', '.join(missing)}")


def test_every_registered_bridge_states_its_doors_and_how_to_open_them() -> None:
    """A new bridge, autopilot or page cannot be left out of the table, or out of the comparison above."""
    own = {name: plug for name, plug in offered().items() if plug.__module__.startswith("uwsim.")}
    opened = {example[0] for example in EXAMPLES.values() if example}
    registered = [*own, *Autopilots.offered(), *Pages.offered()]
    assert opened == {flag_name(name) for name in registered}
    for name, plug in own.items():
        assert plug.doors and all(door.example[0] == flag_name(name) for door in plug.doors)
        flag = Bridges.offered()[name].flags()[name]
        kinds = set(re.findall(r"\b(tcp|udp|udpin|udpout|announce)\b", f"{flag.help} {flag.metavar}"))
        shown = {re.split(r"[: ]", door.example[1])[0] for door in plug.doors if len(door.example) > 1}
        assert kinds <= shown, f"{flag_name(name)}: of the kinds of address {kinds}, only {shown} have a door"


def test_the_table_in_security_md_is_the_present_one() -> None:
    assert PAGE.read_text() == security_page(), "run python -m tools.reference docs/reference"
