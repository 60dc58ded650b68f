"""The pilot's terminal: efforts expire, and are zero however the flight ends."""

import math
import os
import pty
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace

import pytest

from command_line import error_line, uwsim
from uwsim.bridges import RosbridgeServer
from uwsim.channels.families.key import Function
from uwsim.channels.ros.messages import default_message
from uwsim.live import LiveSimulator
from uwsim.operator.cli.teleop import own_server
from uwsim.operator.teleop.app import BLUR, KEY, Screen
from uwsim.operator.teleop.connection import Connection
from uwsim.operator.teleop.hands import DRIVING, FIRST_HOLD_S, REPEAT_HOLD_S, ZERO, Hands
from uwsim.operator.teleop.readout import Readout
from uwsim.simulator.simulator import Simulator
from waiting import until

PUBLISHED = {"w": "surge", "s": "-surge", "d": "-sway", "a": "sway", " ": "heave", "b": "-heave", "i": "pitch",
             "k": "-pitch", "l": "roll", "j": "-roll", "e": "-yaw", "q": "yaw"}  # fmt: skip
"""key_publisher.py of the published simulator; its wire's sway and yaw are positive to starboard, here to port."""


@pytest.fixture
def watch():
    return SimpleNamespace(now_s=100.0)


@pytest.fixture
def hands(watch):
    return Hands(lambda: watch.now_s)


def test_the_driving_keys_are_the_published_nodes():
    assert {key: "-" * (sign < 0) + axis for key, (axis, sign) in DRIVING.items()} == PUBLISHED


def test_an_effort_ends_by_itself_unless_its_key_repeats(hands, watch):
    hands.press("q")
    assert hands.efforts() == ZERO | {"yaw": hands.share}
    watch.now_s += 0.6  # the delay before a keyboard auto-repeats
    for _ in range(50):
        hands.press("q")
        watch.now_s += 0.1
        assert hands.efforts()["yaw"] == hands.share
    watch.now_s += REPEAT_HOLD_S
    assert hands.efforts() == ZERO
    for key in "w,":
        hands.press(key)
        assert hands.has_helm and (key == "w" or hands.tilt() is Function.TILT_DOWN)
        watch.now_s += FIRST_HOLD_S + 0.001
        assert (hands.efforts(), hands.tilt()) == (ZERO, Function.TILT_HOLD)


def test_of_two_held_keys_both_hold_though_only_the_last_repeats(hands, watch):
    hands.press(",")
    assert not hands.has_helm  # viewing does not take the helm
    hands.press("w")
    watch.now_s += 0.5
    hands.press("q")
    for _ in range(20):
        watch.now_s += 0.1
        hands.press("q")
    assert hands.efforts() == ZERO | {"surge": hands.share, "yaw": hands.share}
    watch.now_s += FIRST_HOLD_S
    assert hands.efforts() == ZERO


def test_keys_turn_an_effort_round_stop_give_the_helm_away_and_change_the_share(hands):
    for key, surge, has_helm in (("s", -hands.share, True), ("x", 0.0, True), ("c", 0.0, False)):
        hands.press("w")
        hands.press(key)
        assert (hands.efforts(), hands.has_helm) == (ZERO | {"surge": surge}, has_helm)
    for key, share in (("-", pytest.approx(0.1)), ("=", 1.0)):
        for pressed in key * 9 + "w":
            hands.press(pressed)
        assert hands.efforts()["surge"] == share


def test_everything_is_let_go_when_the_screen_hangs(hands, watch):
    for since_s in (0.2, 0.9):
        hands.beat()
        watch.now_s += since_s
        hands.press("w")
        assert hands.efforts() == ZERO | {"surge": hands.share}
    watch.now_s += 0.2
    assert hands.efforts() == ZERO


def test_no_escape_sequence_is_taken_for_a_key_nor_swallows_one():
    assert KEY.findall("wX ") == ["w", "X", " "]
    assert KEY.findall("\x1b[A\x1b[1;5Dx") == ["\x1b[A", "\x1b[1;5D", "x"]
    assert KEY.findall(BLUR) == [BLUR] and KEY.findall("\x1bx") == ["x"]


def test_the_numbers_and_the_link_are_read():
    readout = Readout()
    message = default_message("uwsim_msgs/msg/Telemetry")
    message.depth, message.distance_to_seabed, message.battery = 5.0, math.inf, 99.5
    for orientation, heading in (((0.0, 0.0, 0.0, 1.0), " 90"), ((math.nan,) * 4, "---")):
        message.orientation = orientation
        readout.read_telemetry(message)
        assert readout.numbers == f"hdg {heading}°  depth  5.0 m  alt beyond m  bat 100%"
    message = default_message("uwsim_msgs/msg/Link")
    for modem, loss, delay_s, expected in (
        ("none", 1.0, 0.0, ("", "LINK DOWN")),
        ("s2cm_hs", 0.5, 0.041, ("s2cm_hs 83% 41 ms, 12 s ago", "LINK LOSES 50%")),
        ("s2cm_hs", 0.0, math.nan, ("s2cm_hs 83%, 12 s ago", "")),
    ):
        message.modem, message.fault_loss, message.delay = modem, loss, delay_s
        message.quality, message.silence_at_station = 0.83, 12.4
        readout.read_link(message)
        assert (readout.link, readout.link_fault) == expected


def screen_of(hands, state="connected"):
    screen = Screen(Connection("ws://127.0.0.1:1", hands))
    screen.connection.state = state
    return screen


def test_all_stop_is_seen_in_any_size_of_the_terminal(hands):
    for state, is_set, is_wanted, expected in (
        ("connected", True, False, "ALL STOP: X"), ("connected", True, True, "ALL STOP: X"),
        ("connected", False, True, "ALL STOP NOT CONF"), ("connected", None, True, "ALL STOP NOT CONF"),
        ("connected", False, False, "no all stop"), ("connected", None, False, "all stop unknown"),
        ("lost", True, False, "all stop unknown"),
    ):  # fmt: skip
        screen = screen_of(hands, state)
        screen.report("a message\n" * 50)
        screen.connection.readout.all_stop, screen.connection.stop_is_wanted = is_set, is_wanted
        for columns in (80, 20):
            line = re.sub(r"\x1b\[[\d;]*\w", "", screen.text(columns).split("\n")[-1]).lstrip("\r")
            assert line.startswith(expected) and len(line) < columns


def test_all_stop_lets_the_keys_go_and_anothers_release_ends_the_wish_for_it(hands):
    screen = screen_of(hands)
    screen.press("x")
    for is_set in (False, True):
        assert screen.connection.stop_is_wanted
        screen.connection.readout.all_stop = is_set
        screen.press("w")
        screen.text(80)
        assert any(hands.efforts().values()) is not is_set
    screen.connection.readout.all_stop = False
    assert "no all stop" in screen.text(80)


def test_a_servers_text_has_no_power_over_the_terminal(hands):
    screen = screen_of(hands)
    screen.connection.readout.warnings = ("BAD\x1b]0;title\x07",)
    screen.report("also\x9b2J\x1b[2J")
    text = screen.text(200)
    assert "BAD" in text and "also" in text and not any(each in text for each in ("\x1b[2J", "\x1b]", "\x07", "\x9b"))


@pytest.fixture
def live():
    with LiveSimulator("pool", speed=1.0) as live:
        live.rov.undock()
        yield live


@pytest.fixture
def server(live):
    with RosbridgeServer(live, port=0) as server:
        yield server


@contextmanager
def connected(server, clock=lambda: 0.0, **options):
    """A keyboard, whose keys hold until they are let go unless a clock is given, connected to a server."""
    connection = Connection(server.url, Hands(clock), **options)
    connection.start()
    until(lambda: connection.state == "connected" and connection.silence_s < 1.0)
    yield connection
    connection.stop()


def test_a_key_drives_until_it_ends_and_a_keyboard_without_the_helm_does_not_stop_another_pilot(live, server):
    said = []
    with connected(server, time.monotonic, report=said.append) as connection:
        hands = connection.hands
        hands.press("w")
        hands.press("q")
        until(lambda: live.rov.effort[0] == 0.5 and live.rov.effort[5] == 0.5)
        until(lambda: not live.rov.effort.any())  # all keys have been released
        connection.call("undock")
        until(lambda: any("is not docked" in text for text in said))
        hands.press("d")
        until(lambda: live.rov.effort[1] == -0.5)
        hands.press("c")
        until(lambda: not live.rov.effort.any())
        live.command("set_effort", vehicle=live.rov.name, heave=0.3).result()
    time.sleep(0.3)
    assert live.rov.effort[2] == 0.3


def test_the_vehicle_stops_when_its_keyboard_or_server_vanishes_and_the_connection_comes_back_with_zero(live, server):
    with connected(server) as connection:
        connection.hands.press("w")
        until(lambda: live.rov.effort[0] == 0.5)
        client = connection.client
        client._loop.call_soon_threadsafe(client._connection.transport.abort)  # as if the machine had disappeared
        until(lambda: not live.rov.effort.any())
        until(lambda: connection.state == "connected" and connection.silence_s < 1.0)
        until(lambda: connection.hands.press("w") or live.rov.effort[0] == 0.5)
        port = server.port
        server.stop()
        until(lambda: connection.state == "lost")
        assert connection.hands.efforts() == ZERO
        with RosbridgeServer(live, port=port):
            until(lambda: connection.state == "connected")
            until(lambda: not live.rov.effort.any())
            connection.stop()


def test_the_screen_flies_and_shows_numbers(live, server):
    screen = Screen(Connection(server.url, Hands(lambda: 0.0)))
    screen.connection.start()
    until(lambda: screen.connection.silence_s < 1.0)
    screen.press("=")
    until(lambda: screen.press("w") or live.rov.effort[0] == 0.75)  # again, since a silence releases all keys
    numbers = r"no all stop  hdg +\d+°  depth +\d+\.\d m  alt +\d+\.\d m  bat +\d+%  lag 0\.\d s  helm 75%  connected"
    assert re.search(numbers, screen.text(100))
    screen.connection.stop()
    until(lambda: not live.rov.effort.any())


def test_a_terminal_that_ends_stops_the_vehicle(live, server):
    for number, code in ((signal.SIGTERM, 130), (signal.SIGHUP, 130), (None, 0)):  # None: Ctrl-Q
        master, slave = pty.openpty()
        process = subprocess.Popen(
            [Path(sys.executable).with_name("uwsim"), "teleop", server.url], stdin=slave, stdout=slave, stderr=slave,
            start_new_session=True, env=os.environ | {"TERM": "xterm-256color"},
        )  # fmt: skip
        os.close(slave)
        try:
            # its output is not read, so the terminal blocks
            until(lambda at=master: (os.write(at, b"w"), time.sleep(0.1)) and live.rov.effort[0] == 0.5)
            os.write(master, b"\x11") if number is None else process.send_signal(number)
            with suppress(OSError):  # until it has ended
                while number is None and os.read(master, 4096):
                    pass
            until(lambda: not live.rov.effort.any())
            assert process.wait(180.0) == code
        finally:
            process.kill()
            process.wait()
            os.close(master)


def test_its_own_simulator_is_flown_over_a_link():
    simulator = Simulator("pool", link="s2cm_hs")
    simulator.rov.undock()
    with own_server(simulator) as server:
        with connected(server) as connection:
            until(lambda: "depth" in connection.readout.numbers)
            until(lambda: connection.hands.press("w") or simulator.rov.effort[0] > 0.0)
            carried = {(counts.topic, counts.sender) for counts in simulator.link.counts() if counts.delivered}
            assert {("key", "station"), ("telemetry", "rov")} <= carried
        until(lambda: simulator.rov.effort[0] == 0.0)


def test_mistakes_are_told_in_a_line():
    for arguments, message in (
        (["http://here"], "must begin with ws:// or wss://"),
        (["ws://127.0.0.1:1", "--scenario", "pool"], "not for a URL"),
        (["ws://127.0.0.1:1", "--link", "s2cm_hs"], "not for a URL"),
        (["--scenario", "pool", "--vehicle", "nobody"], "--vehicle = 'nobody'"),
        (["--scenario", "pool", "--link", "string"], "string"),
        (["ws://127.0.0.1:1"], "stdin is not a terminal"),
    ):
        done = uwsim("teleop", *arguments)
        assert done.returncode == 1
        assert message in error_line(done)
