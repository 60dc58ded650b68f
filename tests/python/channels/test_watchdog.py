"""A vehicle stops when the publisher of its commands falls silent or leaves, on every bridge."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from all_stop_world import scenario
from channel_tools import floats, twist
from uwsim import Simulator
from uwsim.bridges.bridge import Bridge
from uwsim.channels import Channel, Table
from uwsim.channels.ros import build
from uwsim.link import Carrier
from uwsim.live import LiveSimulator

STEPS_S = 200  # steps in a second


def wrench(force_n: float) -> Any:
    return build.message("geometry_msgs/msg/Wrench", force=build.vector((force_n, 0.0, 0.0)))


KEY = build.pose((0.5, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))


class Peers(Bridge):
    """A bridge whose peers are simulated by the test."""

    def __init__(self, live: LiveSimulator, channels: list[Channel]) -> None:
        super().__init__("test", live, channels)

    def say(self, name: str, message: Any) -> None:
        self.apply(self.inputs[name], message)

    def leave_commands(self, name: str) -> None:
        self.abandon(self.inputs[name])


@pytest.fixture
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pair", speed="max", paused=True) as live:
        for k, vehicle in enumerate(live.vehicles.values()):
            vehicle.release()
            vehicle.place([10.0 * k, 0.0, -6.0])
        yield live


@pytest.fixture
def peers(live: LiveSimulator) -> Iterator[Peers]:
    with Peers(live, Table(live.simulator).channels) as peers:
        yield peers


def pushed(live: LiveSimulator) -> dict[str, bool]:
    """Return whether each vehicle's thrusters are commanded."""
    return {
        name: any(abs(one.command) > 1e-3 for one in vehicle.thrusters.values()) or bool(vehicle.effort.any())
        for name, vehicle in live.vehicles.items()
    }


def test_silence_ends_a_velocity_after_half_a_simulated_second(live: LiveSimulator, peers: Peers) -> None:
    for _ in range(10):  # renewed in time, the command is held
        peers.say("scout/cmd_vel", twist(0.4))
        live.step(80)
    assert live.vehicles["scout"].velocity.linear_body_m_s[0] > 0.3
    live.step(10 * STEPS_S)
    assert abs(live.vehicles["scout"].velocity.linear_body_m_s[0]) < 0.05, "as after a command of zero velocity"


def test_silence_ends_forces_at_the_timeout_and_not_before(live: LiveSimulator, peers: Peers) -> None:
    for name, message in (("scout/cmd_wrench", wrench(100.0)), ("scout/cmd_thrusters", floats(*[0.5] * 8))):
        peers.say(name, message)
        live.step(99)
        assert pushed(live)["scout"], name
        live.step(12)  # the timeout and one period of the watchdog
        assert not pushed(live)["scout"], name


def test_a_publisher_that_leaves_ends_its_command_at_once(live: LiveSimulator, peers: Peers) -> None:
    peers.say("scout/cmd_wrench", wrench(100.0))
    for left, stays in (("scout/cmd_vel", True), ("scout/cmd_wrench", False)):  # that of another does not matter
        peers.leave_commands(left)
        live.step(1)
        assert pushed(live)["scout"] == stays


def test_the_timeout_is_a_parameter_and_zero_holds(live: LiveSimulator, peers: Peers) -> None:
    live.command("set_parameter", name="scout.command_timeout_s", value=0.0).result()
    peers.say("scout/cmd_wrench", wrench(100.0))
    live.step(5 * STEPS_S)
    peers.leave_commands("scout/cmd_wrench")
    live.step(5 * STEPS_S)
    assert pushed(live)["scout"]
    live.command("set_parameter", name="scout.command_timeout_s", value=2.0).result()
    live.step(20)
    assert not pushed(live)["scout"], "it has been silent for longer than the new timeout"
    with pytest.raises(ValueError, match=r"scout.command_timeout_s = -1 s: must be in \[0, 1000000\] s"):
        live.command("set_parameter", name="scout.command_timeout_s", value=-1.0).result()


def test_the_published_wire_holds_through_silence(live: LiveSimulator, peers: Peers) -> None:
    peers.say("scout/cmd_vel", twist(0.4))
    live.step(50)
    peers.say("scout/key", KEY)
    live.step(5 * STEPS_S)
    np.testing.assert_array_equal(live.vehicles["scout"].effort, [0.5, 0, 0, 0, 0, 0])
    peers.leave_commands("scout/key")
    live.step(1)
    assert not live.vehicles["scout"].effort.any()


def test_a_service_that_replaces_a_command_is_not_ended_with_it(live: LiveSimulator) -> None:
    table = Table(live.simulator)
    (service,) = [one for one in table.services if one.name == "scout/set_wrench"]
    with Peers(live, table.channels) as peers:
        peers.say("scout/cmd_wrench", wrench(100.0))
        live.step(50)
        answer = service.call(live, {"force_body_n": [50.0, 0.0, 0.0], "torque_body_nm": [0.0, 0.0, 0.0]})
        assert answer["success"], answer
        live.step(5 * STEPS_S)
        assert pushed(live)["scout"]


def test_thrusters_stop_although_the_fins_are_still_commanded(tmp_path: Path) -> None:
    with LiveSimulator(scenario(tmp_path), speed="max", paused=True) as live:
        fins = live.vehicles["fins"]
        with Peers(live, Table(live.simulator).channels) as peers:
            peers.say("fins/cmd_thrusters", floats(1.0))
            for _ in range(4):
                peers.say("fins/cmd_fins", floats(0.1, 0.1, 0.2, 0.2))
                live.step(40)
            (propeller,) = fins.thrusters.values()
            assert propeller.command == 0.0
            assert list(fins.fins.values()) == pytest.approx([0.1, 0.1, 0.2, 0.2], abs=0.02)


def test_over_a_modem_the_station_watches_and_sends_the_end() -> None:
    """Aboard, a pause between two messages may be due to the modem."""
    with LiveSimulator(Simulator("pool", link="tether"), speed="max", paused=True) as live:
        live.rov.release()
        table = Table(live.simulator)
        with Carrier(live, table) as carrier, Peers(live, carrier.channels) as peers:
            peers.say("cmd_wrench", wrench(100.0))
            live.step(2 * STEPS_S)
    sent = [entry.arguments["topic"] for entry in live.log if entry.name == "link_send"]
    forces_n = [entry.arguments["force_body_n"][0] for entry in live.log if entry.name == "set_wrench"]
    assert sent.count("cmd_wrench") == 2 and forces_n == [100.0, 0.0]


def test_a_command_that_is_lost_ends_nothing_aboard(live: LiveSimulator) -> None:
    table = Table(live.simulator)
    with Peers(live, table.channels) as peers:
        peers.say("scout/cmd_vel", twist(0.4))
        live.command("inject_fault", kind="link", vehicle="scout").result()
        peers.say("scout/cmd_wrench", wrench(50.0))
        live.step(80)
        assert table.steering["scout"].is_flown, "it holds the velocity that it knows"
        assert live.vehicles["scout"].velocity.linear_body_m_s[0] > 0.1
