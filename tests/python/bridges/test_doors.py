"""SECURITY.md's table of doors lists every socket on which a program receives, as the system counts them.

And at each of them, a flood delays no stop, holds up no steps and takes little memory.
"""

import os
import re
import shutil
import socket
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path

import pytest
from tools.reference.doors import PAGE, security_page

from client_socket import call, connect
from forked_programs import Programs
from listening_sockets import LISTENS, UPGRADE, free_port, receiving, sockets
from ros1_tools import master, ros_is_installed
from ros2_tools import free_domain
from uwsim.base.options import flag_name
from uwsim.bridges.doors.door import ANYWHERE, LOOPBACK
from uwsim.bridges.doors.table import SERVE, doors
from uwsim.bridges.page import Pages
from uwsim.bridges.requested import Bridges, offered
from uwsim.cli.autopilots import Autopilots
from waiting import until

PATIENCE_S = 5.0
UPGRADING = "\r\n".join(["GET / HTTP/1.1", "Host: localhost", *map(": ".join, UPGRADE.items()), "", ""]).encode()
HEARTBEAT = bytes.fromhex("fe0900ffbe000000000006080000032842")
OPENINGS = {
    SERVE.option: (UPGRADING, b" 101 ", 700), "`--foxglove`": (UPGRADING, b" 101 ", 150),
    "`--mavlink tcp`": (HEARTBEAT, b"\xfd", 40), "`--nmea tcp`": (b"", b"$", 40),
    "`--dvl-a50`": (b'{"command": "get_config"}\n', b'"response_to": "get_config"', 40),
}  # fmt: skip
"""The first words of a client at each TCP door of ours, what the answer contains, and more than it has places for."""
FLOOD = b"\x81\xfe\xea\x60\0\0\0\0" + b'{"a":[' + b"[]," * 19_998
"""A frame of a WebSocket, whose JSON does not end; other protocols take it for anything."""
STOP_S, FLOOD_S, GROWTH_BYTES = 4.0, 1.5, 64 << 20  # 0.05 to 0.8 s and 4 MB beside a load of 10
LAGOON = Path(__file__).parents[3] / "assets/scenarios/lagoon.yaml"
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
    (
        "`serve`, `station`, `replay --as-topics`, `exercise --serve`", "`--station`", "`--ros2`", "`--ros1`",
        "`--foxglove`", "`--video`", "`--mavlink tcp`", "`--nmea tcp`", "`--imc tcp`", "`--moos`",
        "`--ping1d udp`", "`--ping360 udp`", "`--dvl-a50`",
    ),
    ("`--ros2 --rmw zenoh`, instead", "`--mavlink udpin`", "`--nmea udp`", "`--imc udp`"),
    ("`--mavlink udpout`", "`--imc announce`"),
    ("`--ardusub`",),
    ("`--ardusub-binary`",),
)  # fmt: skip
"""The options that one program is given: a process for each would take half a minute of processor time more."""
BESIDE = {"`--ardusub-binary`": ["`--ardusub`"]}
"""The other options' doors that these options open, too."""


@pytest.fixture
def lagoon(tmp_path: Path) -> Path:
    """A scenario with a place on Earth, which some bridges need."""
    path = tmp_path / "lagoon.yaml"
    path.write_text(f"{LAGOON.read_text()}\nearth: {{latitude_deg: 43.8, longitude_deg: -70.3}}\n")
    return path


def test_each_option_is_given_to_one_program() -> None:
    assert Counter(option for options in TOGETHER for option in options) == Counter(list(EXAMPLES))


@contextmanager
def flooded(pid: int) -> Iterator[None]:
    """Send as much as two foes can to each socket of a program, and read nothing."""
    ended = threading.Event()

    def attack(kind: socket.SocketKind, port: int) -> None:
        while not ended.wait(0.01):
            with suppress(OSError), socket.socket(type=kind) as foe:
                foe.settimeout(0.2)
                foe.connect(("127.0.0.1", port))
                foe.sendall(UPGRADING)
                while not ended.wait(0.001):
                    foe.sendall(FLOOD if kind is socket.SOCK_STREAM else FLOOD[:1400])

    doors = [(table, port) for table, _, port, state in sockets(pid) if table.startswith("udp") or state == LISTENS]
    kinds = {"tcp": socket.SOCK_STREAM, "udp": socket.SOCK_DGRAM}
    foes = [threading.Thread(target=attack, args=(kinds[table[:3]], port)) for table, port in 2 * doors]
    for foe in foes:
        foe.start()
    try:
        yield
    finally:
        ended.set()
        for foe in foes:
            foe.join()


def memory(pid: int) -> int:
    """Return the most memory that a process has taken [bytes]."""
    return int(Path(f"/proc/{pid}/status").read_text().partition("VmHWM:")[2].split()[0]) << 10


def hold_to_the_laws_under_a_flood(pid: int, port: int, *, waits: bool) -> None:
    """waits: whether the simulator waits for an autopilot with its steps."""
    before = memory(pid)
    with flooded(pid), connect(f"ws://127.0.0.1:{port}") as pilot:
        since, begun_s, longest_s = call(pilot, "/rosapi/get_time"), time.monotonic(), 0.0
        while time.monotonic() < begun_s + FLOOD_S:
            asked_s = time.monotonic()
            assert call(pilot, "/all_stop", data=True) == (True, {"success": True, "message": ""})
            longest_s = max(longest_s, time.monotonic() - asked_s)
        assert waits or call(pilot, "/rosapi/get_time") != since, "no steps under the flood"
    assert longest_s < STOP_S and memory(pid) - before < GROWTH_BYTES


@pytest.mark.parametrize("options", TOGETHER, ids=lambda options: options[1 if len(options) > 4 else 0])
def test_the_sockets_of_a_program_are_those_of_the_table(
    options: tuple[str, ...], binary: Path, lagoon: Path, tmp_path: Path, programs: Programs
) -> None:
    missing = [option for option in options if not NEEDS.get(option, True)]
    given = [option for option in options if option not in missing]
    if not given:
        pytest.skip(f"not installed: {', '.join(missing)}")
    opened = {*given, *(other for option in given for other in BESIDE.get(option, ()))} - {SERVE.option}
    expected = Counter({(SERVE.protocol, LOOPBACK): SERVE.count})
    for door in DOORS:
        if door.option in opened:  # by default, all but one kind are on loopback
            expected[door.protocol, ANYWHERE if door.address == ANYWHERE else LOOPBACK] += door.count
    port, datagrams = free_port(), str(free_port(socket.SOCK_DGRAM))
    example = [word.replace("{port}", datagrams) for option in given for word in EXAMPLES[option]]
    if "`--ardusub-binary`" in given:
        example.append(str(binary))
    with ExitStack() as stack:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(free_domain())}
        if "`--ros1`" in given:
            environment |= stack.enter_context(master(tmp_path))
        served = programs.greeted("serve", lagoon, "--port", str(port), *example, env=environment)
        program, _ = stack.enter_context(served)
        with suppress(AssertionError):
            until(lambda: receiving(program.pid) == expected)
        assert receiving(program.pid) == expected
        time.sleep(1.0)
        assert receiving(program.pid) == expected, "more were opened later"
        hold_to_the_laws_under_a_flood(program.pid, port, waits="`--ardusub`" in given)
    if missing:
        pytest.skip(f"the others were tried; not installed: {', '.join(missing)}")


def receives(client: socket.socket, words: bytes, limit_s: float = PATIENCE_S) -> bool:
    """Return whether a client is sent these words."""
    client.settimeout(limit_s)
    data = b""
    with suppress(TimeoutError, ConnectionError):
        while not (data and words in data) and (more := client.recv(1 << 12)):
            data += more
    return bool(data) and words in data


def test_silent_clients_shut_no_door_and_listeners_are_served_where_it_speaks_first(
    lagoon: Path, programs: Programs
) -> None:
    """At each TCP door of ours, a newcomer comes in whatever crowd is silent there.

    The crowd has spoken once or never, or has begun to speak, or said something false.
    """
    ports = {door: free_port() for door in DOORS if door.option in OPENINGS and NEEDS.get(door.option, True)}
    words = [
        re.sub(r"\b0$", str(port), word) for door, port in ports.items() for word in door.example or ("--port", "0")
    ]
    with programs.greeted("serve", lagoon, "--nmea-rate", "20", *words):
        for door, port in ports.items():
            opening, answer, crowd = OPENINGS[door.option]
            with ExitStack() as stack:
                come = lambda: stack.enter_context(socket.create_connection(("127.0.0.1", port)))  # noqa: B023, E731
                false = opening[:-1] + bytes(byte ^ 1 for byte in opening[-1:])
                for k in range(crowd):
                    with suppress(ConnectionError):
                        come().sendall((b"", opening, opening[:-2], opening, false, opening)[k % 6])
                newcomer = come()
                newcomer.sendall(opening)
                assert receives(newcomer, answer), f"{door.option}: a newcomer that speaks"
                heard = receives(come(), b"", PATIENCE_S if door.speaks_first else 1.0)
                assert heard == door.speaks_first, f"{door.option}: a newcomer that only listens"


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
