"""The DVL A50: its reports, by the protocol's own example and by the true motion, and its commands."""

import json
import math
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.bridges.a50.plug import A50Options, A50Plug
from uwsim.bridges.a50.reports import beams, covariance, merit
from uwsim.bridges.plug import Context
from uwsim.channels.delivery.feed import Feed
from uwsim.live import LiveSimulator

EXAMPLE_FOM_M_S = 0.00016016385052353144
EXAMPLE_COVARIANCE = np.array([
    [2.4471841442164077e-08, -3.3937477272871774e-09, -1.6659699175747278e-09],
    [-3.3937477272871774e-09, 1.4654466085062268e-08, 4.0409570134514183e-10],
    [-1.6659699175747278e-09, 4.0409570134514183e-10, 1.5971971523143225e-09],
])  # fmt: skip
"""Figure of merit and covariance of the example in Water Linked's description of json_v3.1."""


def plug(text: str = "0") -> A50Plug:
    return A50Plug(A50Options(dvl_a50=(text,)))


class Program:
    """A program that is connected."""

    def __init__(self, live: LiveSimulator, where: str) -> None:
        host, _, port = where.rpartition(":")
        self.live, self.socket = live, socket.create_connection((host, int(port)), 60)
        self.lines = self.socket.makefile()
        live.step(10)  # it is admitted

    def ask(self, command: str, **parameters: Any) -> Any:
        self.socket.sendall(json.dumps({"command": command, "parameters": parameters}).encode() + b"\r\n")
        self.live.step(20)
        return self.next("response")

    def next(self, kind: str) -> Any:
        return next(report for report in map(json.loads, self.lines) if report["type"] == kind)

    def newest(self, kind: str) -> Any:
        """Return the last report so far: the answer to a command comes after it."""
        self.socket.sendall(b'{"command": "mark"}\n')
        self.live.step(20)
        found = None
        for report in map(json.loads, self.lines):
            if report["type"] == "response":
                return found
            found = report if report["type"] == kind else found
        return None


@contextmanager
def connected(**live: Any) -> Iterator[tuple[LiveSimulator, Program]]:
    sim = Simulator("lagoon", seed=2)
    sim.rov.undock()
    with LiveSimulator(sim, paused=True, speed="max", **live) as running, ExitStack() as stack:
        opened = stack.enter_context(plug().open(Context(channels=[], feed=Feed(running), live=running)))
        yield running, Program(running, opened.bridge[0].address)


def test_the_figure_of_merit_is_that_of_the_published_example() -> None:
    assert merit(EXAMPLE_COVARIANCE) == pytest.approx(EXAMPLE_FOM_M_S, rel=1e-6)


def test_the_covariance_is_that_of_four_beams() -> None:
    """With four equal beams, the sums over them are 2 sin^2 for x and y, and 4 cos^2 for z."""
    four = beams({"beam_slant_deg": [22.5], "beam_azimuth_deg": [45.0]})
    assert (four[:, 2] > 0).all(), "z is down"
    assert four[0, :2].tolist() == pytest.approx([math.sin(math.radians(22.5)) / math.sqrt(2)] * 2 * np.array([1, -1]))
    s, c = math.sin(math.radians(22.5)), math.cos(math.radians(22.5))
    expected = np.diag([1 / (2 * s * s), 1 / (2 * s * s), 1 / (4 * c * c)])
    np.testing.assert_allclose(covariance(four, 0.01), 1e-4 * expected, atol=1e-12)


def test_the_position_is_that_of_the_motion_since_the_reset() -> None:
    with connected() as (live, program):
        live.command("set_effort", vehicle="rov", surge=0.4, sway=-0.3, heave=-0.1)
        live.step(500)
        start = live.read(lambda sim: (sim.rov.pose.world_from_body[:3, :3], sim.rov.pose.position_world_m)).result()
        assert program.ask("reset_dead_reckoning") == {
            "response_to": "reset_dead_reckoning", "success": True, "error_message": "", "result": None,
            "format": "json_v3.1", "type": "response",
        }  # fmt: skip
        live.step(30)
        first = program.newest("velocity")
        assert first["velocity_valid"] and first["vx"] > 0.1 and first["vy"] > 0.1 and first["vz"] > 0
        live.step(1000)
        at = program.newest("position_local")
        moved_m = start[0].T @ (live.read(lambda sim: sim.rov.pose.position_world_m).result() - start[1])
        travelled_m = float(np.linalg.norm(moved_m))
        assert travelled_m > 2
        np.testing.assert_allclose([at["x"], -at["y"], -at["z"]], moved_m, atol=0.08 * travelled_m)
        assert 0 < at["std"] < 0.1 and abs(at["roll"]) + abs(at["pitch"]) < 20
        live.step(30)
        newest = program.newest("velocity")
        altitude_m = live.read(lambda sim: sim.rov.sensors["altitude"].read()).result()
        assert newest["altitude"] == pytest.approx(altitude_m, abs=0.5)
        assert [each["beam_valid"] for each in newest["transducers"]] == [True] * 4
        assert newest["time"] == pytest.approx(200, abs=50)


def test_velocities_are_in_proportion_to_the_speed_of_sound_that_is_set() -> None:
    with connected() as (live, program):
        config = program.ask("get_config")["result"]
        assert config["speed_of_sound"] == round(live.simulator.world.water.sound_speed_m_s(-3.0))
        before = program.newest("velocity")["altitude"]
        assert program.ask("set_config", speed_of_sound=1200)["success"]
        live.step(50)
        after = program.newest("velocity")["altitude"]
        assert after / before == pytest.approx(1200 / config["speed_of_sound"], rel=0.05)


def test_without_acoustics_only_triggered_pings_are_reported() -> None:
    with connected() as (live, program):
        assert program.ask("set_config", acoustic_enabled=False)["success"]
        program.newest("velocity")
        live.step(100)
        assert program.newest("velocity") is None
        assert program.ask("trigger_ping")["success"]
        live.step(100)
        assert program.newest("velocity") is not None and program.newest("velocity") is None


def test_a_wrong_command_is_answered_with_its_reason() -> None:
    with connected() as (_, program):
        for parameters, rule in (
            ({"speed_of_sound": 3000}, "speed_of_sound: must be in [1000, 2000]"),
            ({"speed_of_sound": math.nan}, "speed_of_sound: must be in [1000, 2000]"),
            ({"dark_mode_enabled": 1}, "dark_mode_enabled: must be true or false"),
            ({"range_mode": "=1"}, "range_mode: must be auto; the simulated DVL has no other"),
        ):
            answer = program.ask("set_config", **parameters)
            assert (answer["success"], answer["error_message"]) == (False, rule)
        program.socket.sendall(b"{not JSON\n")
        program.live.step(20)
        answer = program.next("response")
        assert not answer["success"] and "not JSON" in answer["error_message"]


def test_a_web_page_is_disconnected() -> None:
    with connected() as (live, program):
        program.socket.sendall(b'POST / HTTP/1.1\r\n\r\n{"command": "set_config"}\n')
        live.step(20)
        assert "response" not in program.lines.read()
