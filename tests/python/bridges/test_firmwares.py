"""Several firmwares in one world, each with its own vehicle, by stand-ins."""

import logging
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from servo_standin import Standin, mixed
from uwsim import Simulator
from uwsim.bridges.ardusub.ardusub import ArduSub, SilentAutopilotError, prepared
from uwsim.bridges.ardusub.options import ArduSubOptions
from uwsim.bridges.firmware.flight import firmware_flying
from uwsim.bridges.firmware.pilot import FirmwarePilot
from uwsim.live import LiveSimulator
from uwsim.live.command_log import replay as replay_log
from uwsim.recording import Recorder
from uwsim.recording.replay import replay
from uwsim.scenario import Scenario, load
from waiting import until

STANDIN = Path(__file__).parent / "firmware_standin.py"
NAMES = ("rov", "scout")
AHEAD, TURN = mixed("vectored_6dof", forward=0.4), mixed("vectored_6dof", yaw=0.2)


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return prepared(load("pair"), names=NAMES)


@pytest.fixture
def sim(scenario: Scenario) -> Simulator:
    return Simulator(scenario)


@contextmanager
def flown(sim: Simulator | LiveSimulator, patience_s: float = 10.0) -> Iterator[list[ArduSub]]:
    """Attach an ArduSub for each vehicle, the last one first."""
    with ExitStack() as stack:
        made = [stack.enter_context(ArduSub(sim, vehicle=name, port=0, patience_s=patience_s)) for name in NAMES[::-1]]
        yield made[::-1]


def late(pulses: list[int], wait_s: float) -> Callable[[dict[str, Any]], list[int]]:
    """Return an autopilot that sends the same pulses, and is late now and then."""
    count = iter(range(10_000))

    def decide(state: dict[str, Any]) -> list[int]:
        time.sleep(wait_s if next(count) % 40 == 5 else 0.0)
        return pulses

    return decide


def test_vehicles_get_thrusters_by_name_and_a_name_must_exist(scenario: Scenario) -> None:
    assert [entry.model.name for entry in scenario.vehicles] == ["bluerov2_heavy_outfit", "bluerov2_heavy"]
    assert prepared(load("pair"), names=["scout"]).vehicles[0].model.name == load("pair").vehicles[0].model.name
    with pytest.raises(ValueError, match="vehicle = 'third': must be one of rov, scout"):
        prepared(load("pair"), names=["rov", "third"])


def test_a_step_is_made_when_all_frames_are_in_whoever_is_late(scenario: Scenario) -> None:
    """Each firmware sees its own vehicle; which frame comes first changes nothing."""

    def ended(first_s: float, second_s: float) -> bytes:
        sim = Simulator(scenario)
        with flown(sim) as (one, two), Standin(one.port, late(AHEAD, first_s)) as first:
            with Standin(two.port, late(TURN, second_s)) as second:
                sim.step(160)
                assert sim.tick == one.counts.frames == two.counts.frames == 160
                until(lambda: min(len(first.lines), len(second.lines)) >= 160, "the answers to all frames")
            for rov, autopilot in zip(sim.vehicles.values(), (first, second), strict=True):
                east, north, up = rov.pose.position_world_m
                np.testing.assert_allclose(autopilot.lines[159]["position"], (north, east, -up), rtol=0, atol=1e-12)
        assert sim.vehicles["rov"].velocity.linear_body_m_s[0] > 0.05
        assert sim.vehicles["scout"].velocity.angular_body_rad_s[2] < -0.05
        return sim.save_state()

    assert ended(0.01, 0.0) == ended(0.0, 0.01)


def test_the_silent_one_is_named(sim: Simulator) -> None:
    with (
        flown(sim, patience_s=0.2) as (one, _),
        Standin(one.port, late(AHEAD, 0)),
        pytest.raises(SilentAutopilotError, match="ArduSub of 'scout': no frame on UDP"),
    ):
        sim.step(5)
    assert sim.tick == 0 and sim.lockstep.is_free


def test_a_firmware_that_leaves_does_not_stop_the_others(sim: Simulator) -> None:
    with ArduSub(sim, vehicle="rov", port=0) as one, Standin(one.port, late(AHEAD, 0)):
        with ArduSub(sim, vehicle="scout", port=0) as two, Standin(two.port, late(TURN, 0)):
            sim.step(20)
        sim.step(20)
    assert (one.counts.frames, two.counts.frames) == (40, 20)


def test_while_one_is_silent_all_stop_and_readings_are_served(sim: Simulator, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)
    with (
        LiveSimulator(sim, speed="max", paused=True) as live,
        flown(live) as (one, two),
        Standin(one.port, late(AHEAD, 0)),
    ):
        live.resume()
        with Standin(two.port, late(TURN, 0), frames=30):
            until(lambda: "ArduSub of 'scout': no frame for 1 s: the world is paused" in caplog.text)
        live.command("all_stop", vehicle="rov").result(timeout=5)
        assert sim.vehicles["rov"].helm.all_stopped and live.tick == 30
        assert "ArduSub of 'rov'" not in caplog.text
        with Standin(two.port, late(TURN, 0)):
            until(lambda: live.tick > 100)


def test_a_flood_of_foreign_packets_delays_no_command(sim: Simulator) -> None:
    ends = threading.Event()

    def flood(port: int) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            while not ends.is_set():
                sender.sendto(b"noise", ("127.0.0.1", port))

    with LiveSimulator(sim, speed="max", paused=True) as live, ArduSub(live, vehicle="rov", port=0) as one:
        thread = threading.Thread(target=flood, args=[one.port])
        thread.start()
        try:
            live.resume()
            until(lambda: one.counts.foreign)
            live.command("all_stop", vehicle="rov").result(timeout=30)
            assert sim.vehicles["rov"].helm.all_stopped and live.tick == 0
        finally:
            ends.set()
            thread.join()


def test_a_pilot_takes_messages_of_its_firmware_only(sim: Simulator) -> None:
    beat, text = dialect.MAVLink_heartbeat_message(12, 3, 0, 0, 0, 3), dialect.MAVLink_statustext_message(2, b"no")
    with ArduSub(sim, vehicle="rov", port=0) as one, FirmwarePilot(one) as pilot, ExitStack() as stack:
        host, port = pilot.address.split(":")
        senders = [stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(2)]
        for sender, message in zip(senders, (beat, text), strict=True):
            sender.sendto(message.pack(dialect.MAVLink(None, 1, 1)), (host, int(port)))
            pilot._receive()
        assert list(pilot.messages) == ["HEARTBEAT"] and pilot.texts == []


def test_recordings_and_logs_replay_to_the_byte(scenario: Scenario, tmp_path: Path) -> None:
    """Also if one firmware starts later, ends earlier, and is stopped meanwhile."""
    sim = Simulator(scenario)
    with (
        Recorder(sim, tmp_path / "two.mcap", topics=["*/odom"]),
        ArduSub(sim, vehicle="rov", port=0) as one,
        Standin(one.port, late(AHEAD, 0.01)),
    ):
        sim.step(37)
        with ArduSub(sim, vehicle="scout", port=0) as two, Standin(two.port, late(TURN, 0.01)):
            sim.step(133)
            sim.vehicles["rov"].all_stop()
            sim.step(50)
        sim.vehicles["rov"].all_stop(False)
        sim.step(40)
    result = replay(tmp_path / "two.mcap")
    assert result.difference is None and result.state_compared
    with LiveSimulator(Simulator(scenario), speed="max", paused=True) as live:
        with flown(live) as (one, two), Standin(one.port, late(AHEAD, 0)), Standin(two.port, late(TURN, 0), 120):
            live.resume()
            until(lambda: live.tick == 120)
            live.pause()
        state = live.read(lambda sim: sim.save_state()).result()
    assert replay_log(Simulator(scenario), live.log, 120).save_state() == state


def test_programs_have_systems_ports_and_folders_of_their_own(scenario: Scenario, tmp_path: Path) -> None:
    sim = Simulator(scenario)
    binary = tmp_path / "ardusub"
    binary.write_bytes(STANDIN.read_bytes())
    binary.chmod(0o755)
    options = ArduSubOptions(
        ardusub=True, ardusub_binary=binary, ardusub_fly=NAMES, ardusub_folder=str(tmp_path / "own")
    )
    with options.flying(sim) as text:
        sim.step(3)
        lines = [
            Path(f"/proc/{(tmp_path / 'own' / name / 'pid.txt').read_text()}/cmdline").read_text().split("\0")
            for name in NAMES
        ]
    assert sim.tick == 3 and "flies 'rov'" in text and "flies 'scout'" in text and "as system 2" in text
    words = [dict(word[2:].split("=", 1) for word in line if word.startswith("--")) for line in lines]
    assert [(each["sysid"], each["rc-in-port"]) for each in words] == [("1", "5501"), ("2", "5511")]
    assert all(words[0][key] != words[1][key] for key in ("sim-port-out", "serial1"))
    assert words[0]["serial0"] == words[1]["serial0"] == "udpclient:127.0.0.1:14550"


@pytest.mark.skipif("UWSIM_ARDUSUB" not in os.environ, reason="needs UWSIM_ARDUSUB, a compiled ArduSub")
def test_two_compiled_firmwares_hold_their_depth(scenario: Scenario) -> None:
    """Twice the same bytes."""
    binary = Path(os.environ["UWSIM_ARDUSUB"])

    def ended() -> bytes:
        sim = Simulator(scenario)
        sim.vehicles["rov"].place((5.0, 5.0, -1.0))
        sim.vehicles["scout"].place((-5.0, 5.0, -1.0))
        with flown(sim) as subs, ExitStack() as stack:
            pilots = [stack.enter_context(FirmwarePilot(sub, 1 + k)) for k, sub in enumerate(subs)]
            for k, (sub, pilot) in enumerate(zip(subs, pilots, strict=True)):
                options = {"station": pilot.address, "system": 1 + k, "parameters": {"LOG_BACKEND_TYPE": 0}}
                stack.enter_context(firmware_flying(sub, binary, **options))  # type: ignore[arg-type]
            for pilot in pilots:
                pilot.each = lambda: [each.exchange() for each in pilots]
            pilots[0].get_ready()
            for pilot in pilots:
                pilot.arm()
                pilot.mode("ALT_HOLD")
                pilot.steer(z=200)
            for pilot, seconds in zip(pilots, (8, 4), strict=True):
                pilots[0].fly(seconds)
                pilot.steer()
            pilots[0].fly(8)
            before_m = [pilot.ned_m[2] for pilot in pilots]
            pilots[0].fly(10)
            after_m = [pilot.ned_m[2] for pilot in pilots]
            assert min(before_m) > 1.5 and abs(before_m[0] - before_m[1]) > 0.3
            np.testing.assert_allclose(before_m, after_m, atol=0.1)
            return sim.save_state()

    assert ended() == ended()
