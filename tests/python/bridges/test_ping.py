"""Ping1D and Ping360: the wire, the devices in simulated time, and Blue Robotics' own library as their program."""

import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import brping
import numpy as np
import pytest
from brping import definitions as ids
from brping.pingmessage import PingMessage

from uwsim import Simulator
from uwsim.bridges.ping_protocol import wire
from uwsim.bridges.ping_protocol.device import Device
from uwsim.bridges.ping_protocol.ping360 import STEP_NS
from uwsim.bridges.ping_protocol.plug import Ping1dOptions, Ping1dPlug, Ping360Options, Ping360Plug
from uwsim.bridges.ping_protocol.wire import Message, Reader, encoded
from uwsim.bridges.plug import Context
from uwsim.channels.delivery.feed import Feed
from uwsim.live import LiveSimulator
from uwsim.scenario import Scenario, load
from uwsim.scenario.read.validated import validated

REQUEST = bytes.fromhex("42 52 02 00 06 00 00 00 05 00 a1 00")
"""The request for the protocol's version, as in the protocol's documentation."""
WALL = {"kind": "box", "name": "wall", "size_m": [20, 0.5, 8], "position_m": [-20, -23.25, -4]}
"""A wall whose near face is 5 m south of the vehicle: to starboard."""


def world(*, noise: bool = True) -> Simulator:
    lagoon = load("lagoon")
    silent = {} if noise else {"sensors": {"altitude": {"kind": "altitude", "rate_hz": 15, "range_max_m": 100}}}
    rov = {"name": "rov", "model": {"builds_on": "bluerov2_heavy_outfit", "name": "rov", **silent}, "start": "station"}
    given = {**lagoon.given(), "vehicles": [rov], "obstacles": [WALL], "survey": None}
    return Simulator(validated(Scenario, {key: value for key, value in given.items() if value is not None}), seed=3)


class Program:
    """A program by UDP that reads with the maker's library."""

    def __init__(self, device: Device) -> None:
        self.device, self.reader = device, Reader()
        self.socket = socket.socket(type=socket.SOCK_DGRAM)
        self.socket.settimeout(60)
        line: Any = device.line
        self.socket.connect((line.host, line.port))

    def tell(self, number: int, **values: Any) -> None:
        self.socket.send(encoded(number, values, source=255))

    def answer(self) -> tuple[int, Any]:
        found = PingMessage(msg_data=self.socket.recv(4096), payload_dict=wire.MESSAGES)
        values = {name: getattr(found, name) for name in found.payload_field_names}
        tail = [bytes(value) for value in values.values() if not isinstance(value, int)]
        return found.message_id, values | {"tail": tail[0] if tail else b""}

    def ask(self, number: int) -> Any:
        self.tell(ids.COMMON_GENERAL_REQUEST, requested_id=number)
        got, values = self.answer()
        assert got == number, values["tail"]
        return values


@contextmanager
def opened(sim: Simulator, plug: Any, **live: Any) -> Iterator[tuple[LiveSimulator, list[Device]]]:
    with LiveSimulator(sim, **live) as running, ExitStack() as stack:
        context = Context(channels=[], feed=Feed(running), live=running)
        yield running, stack.enter_context(plug.open(context)).bridge


def ping1d(text: str = "udp:0") -> Ping1dPlug:
    return Ping1dPlug(Ping1dOptions(ping1d=(text,)))


def ping360(text: str = "udp:0") -> Ping360Plug:
    return Ping360Plug(Ping360Options(ping360=(text,)))


def transmit(program: Program, angle: int, **changed: int) -> None:
    usual = {"mode": 1, "gain_setting": 1, "transmit_duration": 32, "sample_period": 400, "transmit_frequency": 750}
    values = {**usual, "number_of_samples": 1000, "transmit": 1, "reserved": 0, **changed}
    program.tell(2601, angle=angle, **values)


def test_a_message_is_that_of_the_documentation() -> None:
    assert encoded(ids.COMMON_GENERAL_REQUEST, {"requested_id": ids.COMMON_PROTOCOL_VERSION}, source=0) == REQUEST
    (found,) = Reader().read(REQUEST)
    assert found == Message(6, b"\x05\x00", 0) and found.values == {"requested_id": 5}


@pytest.mark.parametrize("size", [1, 2, 5, 100])
def test_messages_are_found_between_noise_and_broken_ones(size: int) -> None:
    broken = REQUEST[:-2] + b"\x00\x00"
    long = wire.HEADER.pack(b"BR", 60_000, 6, 0, 0)
    stream, reader = b"UB" + REQUEST + broken + long + REQUEST + b"B", Reader()
    found = [each for k in range(0, len(stream), size) for each in reader.read(stream[k : k + size])]
    assert [each.number for each in found] == [6, 6]


@pytest.mark.parametrize(
    ("plug", "rule"),
    [
        (ping1d("sonar=udp:0"), "ping1d: instrument 'sonar' of vehicle 'rov': must be altitude"),
        (ping1d("boat/altitude=udp:0"), "ping1d: vehicle 'boat': must be one of rov"),
        (ping360(), "ping360: vehicle 'rov' must have an imaging sonar of kind forward_looking"),
    ],
)
def test_an_instrument_that_is_not_there_is_refused(plug: Any, rule: str) -> None:
    with pytest.raises(ValueError, match=rule), opened(Simulator("lagoon"), plug, paused=True):
        pass


def test_ping1d_measures_the_altimeters_height_by_the_speed_of_sound_it_is_set_to() -> None:
    sim = world(noise=False)
    with opened(sim, ping1d(), paused=True, speed="max") as (live, (device,)):
        live.step(100)
        program = Program(device)
        height_m = live.read(lambda sim: sim.rov.sensors["altitude"].read()).result()
        sound_m_s = sim.world.water.sound_speed_m_s(float(sim.rov.pose.position_world_m[2]))
        for set_m_s in (1500, 1400):
            program.tell(1002, speed_of_sound=1000 * set_m_s)
            assert program.answer() == (ids.COMMON_ACK, {"acked_id": 1002, "tail": b""})
            seen = program.ask(1300)
            assert seen["distance"] == pytest.approx(1000 * height_m * set_m_s / sound_m_s, abs=1)
            profile = np.frombuffer(seen["tail"], np.uint8)
            assert seen["confidence"] == 100 and len(profile) == seen["profile_data_length"] == 200
            first = float(np.argmax(profile > 128)) * seen["scan_length"] / 200  # the beam sees the nearest of the bed
            assert 0.9 * seen["distance"] < first < 1.05 * seen["distance"]
        program.tell(1001, scan_start=0, scan_length=2000)
        program.answer()
        program.tell(1003, mode_auto=0)
        program.answer()
        assert program.ask(1211)["confidence"] == 0, "the bed is out of the scan"
        program.tell(1001, scan_start=90_000, scan_length=200)
        number, refused = program.answer()
        assert number == ids.COMMON_NACK and b"scan_start: must be less than 99 times scan_length" in refused["tail"]


def test_ping1d_pings_at_multiples_of_its_interval_in_simulated_time() -> None:
    with opened(world(), ping1d(), paused=True, speed="max") as (live, (device,)):
        program = Program(device)
        program.tell(1400, id=1300)
        numbers = [program.answer(), program.answer()][1][1]["ping_number"]
        live.step(round(0.1 / live.simulator.step_s))
        assert program.answer()[1]["ping_number"] == numbers + 1


def test_ping360_looks_clockwise_from_ahead_and_finds_the_wall_where_it_is() -> None:
    sim = world()
    sound_m_s = sim.world.water.sound_speed_m_s(-3.0)
    seen: dict[int, Any] = {}
    with opened(sim, ping360(), paused=True, speed="max") as (live, (device,)):
        program = Program(device)
        for angle in (100, 300):
            transmit(program, angle)
            until_answer(live, program, seen, angle)
    bin_m = 0.5 * sound_m_s * 400 * 25e-9
    to_port, to_starboard = (np.frombuffer(seen[angle]["tail"], np.uint8).astype(float) for angle in (100, 300))
    wall = slice(int(4.5 / bin_m), int(5.5 / bin_m))
    assert to_starboard[wall].max() - to_port[wall].max() > 60
    assert (wall.start + np.argmax(to_starboard[wall])) * bin_m == pytest.approx(5.0, abs=0.15)


def until_answer(live: LiveSimulator, program: Program, seen: dict[int, Any], angle: int) -> None:
    """Step until the answer is there, and check that it came no sooner than the sound and the motor."""
    began_ns = live.time_ns
    program.socket.settimeout(0.01)
    while angle not in seen:
        try:
            seen[angle] = program.answer()[1]
        except TimeoutError:
            live.step(1)
            assert live.time_ns - began_ns < 20e9, "no answer"
    assert live.time_ns - began_ns >= 1000 * 400 * 25 + STEP_NS
    program.socket.settimeout(60)


def test_the_same_ping_of_the_same_moment_is_the_same() -> None:
    seen: list[Any] = []
    for _ in range(2):
        with opened(world(), ping360(), paused=True, speed="max") as (live, (device,)):
            live.step(50)
            program, found = Program(device), dict[int, Any]()
            transmit(program, 300)
            until_answer(live, program, found, 300)
            seen.append(found[300])
    assert seen[0] == seen[1] and any(seen[0]["tail"])


def test_ping360_scans_a_sector_there_and_back_until_it_is_stopped() -> None:
    with opened(world(), ping360(), speed="max") as (_, (device,)):
        program = Program(device)
        sector = {"start_angle": 390, "stop_angle": 10, "num_steps": 10, "delay": 0}
        program.tell(2602, mode=1, gain_setting=1, transmit_duration=32, sample_period=80, transmit_frequency=750,
                     number_of_samples=200, **sector)  # fmt: skip
        assert program.answer()[0] == ids.COMMON_ACK
        assert [program.answer()[1]["angle"] for _ in range(6)] == [390, 0, 10, 0, 390, 0]
        program.tell(2903)
        while program.answer()[0] != ids.COMMON_ACK:
            pass
        transmit(program, 7, transmit=0)
        assert program.answer()[1]["angle"] == 7
        transmit(program, 400)
        number, refused = program.answer()
        assert (number, refused["nacked_id"]) == (ids.COMMON_NACK, 2601)
        assert refused["tail"] == b"angle = 400: must be in [0, 399]"


def test_blue_robotics_library_runs_unmodified() -> None:
    both = Ping1dPlug(Ping1dOptions(ping1d=("udp:0", "pty")))
    with opened(world(), both) as (live, (by_udp, by_pty)):
        # Ping1D() takes the messages of the S500, of which some have the same numbers, for its own.
        first, second = (brping.Ping1D(ids.payload_dict_ping1d) for _ in range(2))
        first.connect_udp("127.0.0.1", by_udp.line.port)  # type: ignore[attr-defined]
        second.connect_serial(by_pty.line.address)
        for sonar in (first, second):
            assert sonar.initialize()
            assert sonar.get_device_information()["device_type"] == 1
            assert sonar.set_mode_auto(0) and sonar.set_range(0, 9000) and sonar.set_gain_setting(2)
            assert sonar.set_ping_interval(70) and sonar.get_range() == {"scan_start": 0, "scan_length": 9000}
            assert len(sonar.get_profile()["profile_data"]) == 200
            assert sonar.set_device_id(9) and sonar.get_device_id() == {"device_id": 9}
    with opened(world(), ping360()) as (live, (device,)):
        sonar = brping.Ping360()
        sonar.connect_udp("127.0.0.1", device.line.port)  # type: ignore[attr-defined]
        assert sonar.initialize() and sonar.set_number_of_samples(300).name == "device_data"
        assert sonar.set_gain_setting(3).name == "nack"
        for angle in (0, 399):
            data = sonar.transmitAngle(angle)
            assert (data.angle, len(data.data)) == (angle, 300)
        assert live.error is None
