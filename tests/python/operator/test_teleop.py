"""The pilot's terminal: efforts expire, and are zero however the flight ends."""

import asyncio
import math
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from rich.text import Text
from textual import events

from command_line import error_line, uwsim
from uwsim.bridges import RosbridgeServer
from uwsim.channels.families.key import Function
from uwsim.live import LiveSimulator
from uwsim.operator.cli.teleop import own_server
from uwsim.operator.teleop.app import TeleopApp
from uwsim.operator.teleop.connection import Connection
from uwsim.operator.teleop.fan import draw_fan, fan_scale_m
from uwsim.operator.teleop.gamepad import FULL, Gamepads, shaped
from uwsim.operator.teleop.hands import FIRST_HOLD_S, REPEAT_HOLD_S, ZERO, Hands
from uwsim.operator.teleop.readout import Readout, read_state_data
from uwsim.operator.teleop.tapes import depth_tape, heading_tape
from uwsim.operator.teleop.terminal import ReleaseParser
from uwsim.simulator.simulator import Simulator
from waiting import until

UWSIM = Path(sys.executable).with_name("uwsim")
PATIENCE_S = 60.0


class Watch:
    """A clock set by the test."""

    now_s = 100.0

    def __call__(self):
        return self.now_s


@pytest.fixture
def watch():
    return Watch()


@pytest.fixture
def hands(watch):
    return Hands(watch)


def test_an_effort_ends_by_itself(hands, watch):
    hands.press("w")
    assert hands.efforts() == ZERO | {"surge": hands.share}
    watch.now_s += FIRST_HOLD_S + 0.001
    assert hands.efforts() == ZERO


def test_a_key_that_repeats_holds_until_it_does_no_longer(hands, watch):
    hands.press("q")
    watch.now_s += 0.6  # the delay before a keyboard auto-repeats
    for _ in range(50):
        hands.press("q")
        watch.now_s += 0.1
        assert hands.efforts()["yaw"] == hands.share
    watch.now_s += REPEAT_HOLD_S
    assert hands.efforts() == ZERO


def test_of_two_held_keys_both_hold_though_only_the_last_repeats(hands, watch):
    hands.press("w")
    watch.now_s += 0.5
    hands.press("q")
    for _ in range(20):
        watch.now_s += 0.1
        hands.press("q")
    assert hands.efforts() == ZERO | {"surge": hands.share, "yaw": hands.share}
    watch.now_s += FIRST_HOLD_S
    assert hands.efforts() == ZERO


def test_the_opposite_key_turns_the_effort_round_at_once(hands):
    hands.press("w")
    hands.press("s")
    assert hands.efforts()["surge"] == -hands.share


def test_where_releases_are_told_a_key_holds_until_it_is_let_go(hands, watch):
    hands.reports_releases = True
    hands.press(" ")
    watch.now_s += 1000.0
    assert hands.efforts()["heave"] == hands.share
    hands.release(" ")
    assert hands.efforts() == ZERO


def test_everything_is_let_go_when_the_screen_hangs(hands, watch):
    hands.reports_releases = True
    hands.beat()
    hands.press("w")
    watch.now_s += 0.9
    assert hands.efforts()["surge"] == hands.share
    watch.now_s += 0.2
    assert hands.efforts() == ZERO


def test_stop_lets_everything_go_and_giving_the_helm_away_as_well(hands):
    hands.reports_releases = True
    for key, has_helm in (("x", True), ("c", False)):
        hands.press("w")
        hands.set_sticks({"yaw": 1.0})
        hands.press(key)
        assert hands.efforts() == ZERO
        assert hands.has_helm is has_helm


def test_the_share_scales_keys_and_sticks_together_and_stays_within_one(hands):
    hands.change_share(-99)
    hands.press("w")
    hands.set_sticks({"surge": 1.0, "sway": -0.5})
    assert hands.efforts()["surge"] == pytest.approx(0.1)
    assert hands.efforts()["sway"] == pytest.approx(-0.05)
    hands.change_share(99)
    assert hands.efforts()["surge"] == 1.0


def test_a_sonar_tilts_while_its_key_is_held(hands, watch):
    hands.press(",")
    assert hands.tilt() is Function.TILT_DOWN
    assert not hands.has_helm  # viewing does not take the helm
    watch.now_s += 1.0
    assert hands.tilt() is Function.TILT_HOLD


def test_the_kitty_protocol_tells_of_presses_repeats_and_releases():
    released = []
    parser = ReleaseParser(released.append)

    def typed(text):
        return [event.character for event in parser.feed(text) if isinstance(event, events.Key)]

    assert typed("\x1b[119;1:1;119u") == ["w"]
    assert typed("\x1b[119;1:2;119u") == ["w"]
    assert released == []
    assert typed("\x1b[119;1:3u\x1b[32;1:3u") == []
    assert released == ["w", " "]
    assert len(typed("\x1b[1;1:1A\x1b[1;1:3A")) == 1  # an arrow key's press and release
    assert typed("ab") == ["a", "b"]  # from any other terminal


def test_the_published_panel_is_read():
    readout = Readout()

    class Message:
        data = "0.5a0.1a18a150.3a5a12.5aInfinitya60a99.5a"

    read_state_data(readout, Message)
    assert (readout.depth_m, readout.battery_percent) == (5.0, 99.5)
    assert math.isinf(readout.seabed_m)
    Message.data = "1a2a"
    with pytest.raises(ValueError, match="stateData: 2 values: must be 9"):
        read_state_data(readout, Message)


def test_the_fan_has_an_echo_where_it_is():
    angles = np.radians([-45.0, 0.0, 45.0])
    port = draw_fan(angles, np.array([np.inf, np.inf, 9.0], np.float32), 60, 20)
    starboard = draw_fan(angles, np.array([9.0, np.inf, np.inf], np.float32), 60, 20)

    def column(picture):
        (span,) = [span for span in picture.spans if span.style == "bold cyan"]
        return (span.start % 61, span.start // 61)

    assert column(port)[0] < 30 < column(starboard)[0]
    assert column(port)[1] == column(starboard)[1]
    assert column(port)[0] + column(starboard)[0] == 59  # mirror images


def test_the_fans_scale_shows_nine_in_ten_echoes():
    assert fan_scale_m(np.full(100, 9.9, np.float32)) == 10.0
    assert fan_scale_m(np.r_[np.full(89, 9.0), np.full(11, 50.0)].astype(np.float32)) == 60.0
    assert fan_scale_m(np.full(5, np.inf, np.float32)) == 100.0


def test_tapes_point_where_the_vehicle_does():
    tape = heading_tape(90.0, 41).plain.split("\n")[0]
    assert tape[20] == "E"
    assert tape.index("075") < 20 < tape.index("105") if "075" in tape else True
    lines = depth_tape(2.0, 1.0, 11).plain.split("\n")
    assert "2.0 m" in lines[5]
    assert lines[1].startswith("~")  # the surface, 2 m above
    assert [line.startswith("▒") for line in lines[6:9]] == [False, True, True]  # the bed, 1 m below


def test_sticks_do_not_drift_and_reach_full_effort():
    assert shaped(int(0.1 * FULL)) == 0.0
    assert shaped(FULL) == 1.0
    assert shaped(-FULL - 1) == -1.0
    values = [shaped(v) for v in range(-FULL, FULL, 500)]
    assert values == sorted(values)


def test_a_pads_sticks_and_buttons_have_their_meaning():
    class Pad:
        axes = (0, 0, 0, -FULL)  # right stick forward
        buttons = frozenset({0})

        def get_axis(self, axis):
            return self.axes[axis]

        def get_button(self, button):
            return button in self.buttons

    pads, pad = Gamepads(), Pad()
    efforts, pressed, released = pads.read(pad)
    assert efforts["surge"] == 1.0
    assert (pressed, released) == (["x"], [])
    pad.buttons = frozenset()
    assert pads.read(pad)[1:] == ([], ["x"])


# Against a simulator


@pytest.fixture
def live():
    with LiveSimulator("pool", speed=1.0) as live:
        live.rov.undock() if not live.rov.released else None
        yield live


@pytest.fixture
def server(live):
    with RosbridgeServer(live, port=0) as server:
        yield server


def connected(server, hands):
    said = []
    connection = Connection(server.url, hands, report=said.append)
    connection.said = said
    connection.start()
    until(lambda: connection.state == "connected" and connection.silence_s < 1.0)
    return connection


def test_a_key_drives_the_vehicle_and_its_end_stops_it(live, server):
    hands = Hands()
    connection = connected(server, hands)
    hands.press("w")
    hands.press("q")
    until(lambda: live.rov.effort[0] == 0.5 and live.rov.effort[5] == 0.5)
    until(lambda: not live.rov.effort.any())  # all keys have been released
    hands.press("d")
    until(lambda: live.rov.effort[1] == -0.5)
    connection.stop()
    until(lambda: not live.rov.effort.any())


def test_a_connection_that_is_lost_stops_the_vehicle_and_comes_back_with_zero(live, server):
    hands = Hands()
    hands.reports_releases = True
    connection = connected(server, hands)
    hands.press("w")
    until(lambda: live.rov.effort[0] == 0.5)
    port = server.port
    server.stop()
    until(lambda: connection.state == "lost")
    assert hands.efforts() == ZERO
    with RosbridgeServer(live, port=port):
        until(lambda: connection.state == "connected")
        until(lambda: not live.rov.effort.any())
        connection.stop()


def test_the_vehicle_stops_when_its_keyboard_vanishes(live, server):
    hands = Hands()
    hands.reports_releases = True
    connection = connected(server, hands)
    hands.press("w")
    until(lambda: live.rov.effort[0] == 0.5)
    socket = connection._node._connection
    socket._loop.call_soon_threadsafe(socket._connection.transport.abort)  # as if the machine had disappeared
    until(lambda: not live.rov.effort.any())
    connection.stop()


def test_a_vanished_keyboard_does_not_stop_another_pilot(live, server):
    connection = connected(server, Hands())
    connection.hands.press("w")
    until(lambda: live.rov.effort[0] == 0.5)
    connection.hands.press("c")
    until(lambda: not live.rov.effort.any())
    live.command("set_effort", vehicle=live.rov.name, heave=0.3).result()
    connection.stop()
    time.sleep(0.3)
    assert live.rov.effort[2] == 0.3


def test_what_a_service_answers_is_told(live, server):
    connection = connected(server, Hands())
    connection.call("undock")  # already undocked
    until(lambda: any("is not docked" in text for text in connection.said))
    connection.stop()


def test_the_screen_flies_and_ends_with_zero(live, server):
    async def fly():
        hands = Hands()
        hands.reports_releases = True  # a key counts as held until it is released, however slow the screen is
        app = TeleopApp(Connection(server.url, hands), "pool")
        async with app.run_test(size=(120, 40)) as pilot:
            while app.connection.silence_s > 1.0:
                await pilot.pause(0.05)
            await pilot.press("=", "w")
            while live.rov.effort[0] != 0.75:
                await pilot.press("w")  # again, because a brief silence of the server releases all keys
                await pilot.pause(0.05)
            await pilot.press("m")
            app.draw()
            text = app.export_screenshot()
            assert "depth" in text and "75" in text
            assert len(app.marks) == 1
        app.draw()  # timers and queued calls still arrive while the screen is being taken down
        app._write(Text("a line from another thread"))
        app.connection.stop()

    asyncio.run(asyncio.wait_for(fly(), PATIENCE_S))
    until(lambda: not live.rov.effort.any())


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_a_terminal_that_ends_stops_the_vehicle(live, server, number):
    master, slave = pty.openpty()
    process = subprocess.Popen(
        [UWSIM, "teleop", server.url], stdin=slave, stdout=slave, stderr=slave, start_new_session=True,
        env=os.environ | {"TERM": "xterm-256color"},
    )  # fmt: skip
    os.close(slave)
    try:
        deadline = time.monotonic() + PATIENCE_S
        while live.rov.effort[0] != 0.5:
            assert time.monotonic() < deadline
            os.write(master, b"\x1b[119;1:1;119u\x1b[32;1:3u")  # a key release occurs only in kitty
            time.sleep(0.1)  # its output is not read, so the terminal blocks
        process.send_signal(number)
        until(lambda: not live.rov.effort.any())
        until(lambda: process.poll() is not None)
        assert process.returncode == (-number if number == signal.SIGKILL else 130)
    finally:
        process.kill()
        process.wait()
        os.close(master)


def test_its_own_simulator_is_flown_over_a_link():
    simulator = Simulator("pool", link="s2cm_hs")
    simulator.rov.undock()
    with own_server(simulator) as server:
        hands = Hands()
        connection = Connection(server.url, hands)
        connection.start()
        try:
            until(lambda: connection.readout.depth_m > 0.0)
            hands.press("w")
            until(lambda: simulator.rov.effort[0] > 0.0 or hands.press("w"))
            carried = {(counts.topic, counts.sender) for counts in simulator.link.counts() if counts.delivered}
            assert {("key", "station"), ("telemetry", "rov")} <= carried
        finally:
            connection.stop()
        until(lambda: simulator.rov.effort[0] == 0.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["http://here"], "must begin with ws:// or wss://"),
        (["ws://127.0.0.1:1", "--scenario", "pool"], "not for a URL"),
        (["ws://127.0.0.1:1", "--link", "s2cm_hs"], "not for a URL"),
        (["--scenario", "pool", "--vehicle", "nobody"], "--vehicle = 'nobody'"),
        (["--scenario", "pool", "--link", "string"], "string"),
        (["ws://127.0.0.1:1"], "stdin is not a terminal"),
    ],
)
def test_mistakes_are_told_in_a_line(arguments, message):
    done = uwsim("teleop", *arguments)
    assert done.returncode == 1
    assert message in error_line(done)
