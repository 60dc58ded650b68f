"""The ROS 2 node, as seen by a real ROS 2 Jazzy: rclpy on Fast DDS, which tools/setup --dev installs."""

import json
import os
import signal
import statistics
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ros2_tools import free_domain, until
from uwsim.bridges.doctor.discovery import discovery
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings
from uwsim.channels import Channel, Table
from uwsim.channels.calls.rcl_parameters import rcl_parameter_services
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.messages import from_bytes, typestore
from uwsim.channels.ros.type_hash import type_hash
from uwsim.exercises import load_exercise
from uwsim.league.new import new_team
from uwsim.live import LiveSimulator

HERE = Path(__file__).parents[1]
JAZZY = HERE.parents[1] / "build/jazzy"
pytestmark = pytest.mark.skipif(
    not (JAZZY / "ready").is_file(), reason="no rclpy: tools/setup --dev installs it where the index has it"
)
SURGE = "rov.drag.linear.surge"
SETTINGS = Ros2Settings(domain_id=free_domain())
SET_BOOL, TRIGGER = "std_srvs/srv/SetBool", "std_srvs/srv/Trigger"
FLOAT = "std_msgs/msg/Float64"
CALLS, STAMPS, FOLLOWED = 30, 40, 5


class Client:
    """A running client. variables: of its environment."""

    def __init__(self, *words, **variables):
        environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(SETTINGS.domain_id),
            "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
            **variables,
        }
        command = [JAZZY / "bin/python", HERE / "jazzy_client.py", *words]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        self.process = subprocess.Popen(command, **pipes, text=True, env=environment)

    def send(self, line):
        """Write a line to its input."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def ask(self, operation, **arguments):
        """Return an operation's value."""
        self.send(json.dumps([operation, arguments]))
        found = json.loads(self.process.stdout.readline())
        assert "value" in found, found["error"]
        return found["value"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.process.communicate(timeout=10.0)  # it removes its shared memory
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


@pytest.fixture(scope="module")
def client():
    with Client(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST") as client:
        yield client


@pytest.fixture(scope="module")
def pilot():
    # Within this machine it would use shared memory, which it leaves behind when it is killed.
    with Client("pilot", ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET", FASTDDS_BUILTIN_TRANSPORTS="UDPv4") as pilot:
        yield pilot


@pytest.fixture(scope="module")
def live(client, pilot):  # which start meanwhile
    with LiveSimulator("pool") as live:
        yield live


@pytest.fixture(scope="module")
def node(live):
    table = Table(live.simulator)
    sent = Channel("sent", FLOAT, "out", "", rate_hz=100.0, read=lambda sim: build.message(FLOAT, data=time.time()))
    with Ros2Node(live, [*table.channels, sent], table.services, SETTINGS) as node:
        yield node


def is_in_jazzy(kind):
    """Return whether a type belongs to one of the installed packages."""
    return (JAZZY / f"share/{kind}.json").is_file()


def report(what, values_ms):
    """Print a measurement, for `pytest -s`: values depend on the machine and its load."""
    sys.stdout.write(f"\n{what}: median {statistics.median(values_ms):.1f} ms, at most {max(values_ms):.1f} ms\n")


def test_type_hashes_are_those_that_rosidl_wrote_into_its_packages(node):
    own = {one.type for one in (*node.channels, *node.services.values(), *rcl_parameter_services("uwsim"))}
    known = sorted(filter(is_in_jazzy, own))
    for kind in known:
        for published in json.loads((JAZZY / f"share/{kind}.json").read_text())["type_hashes"]:
            assert published["hash_string"] == type_hash(typestore(), published["type_name"])
    assert len(known) > 30


def test_each_side_discovers_the_other(client, node):
    topics = {f"/{channel.name}": channel.type for channel in node.channels}
    services = {f"/{service.name}": [service.type] for service in node.services.values()}
    found = client.ask("graph", topics=list(topics), services=list(services))
    assert {("uwsim", "/"), ("client", "/")} <= set(map(tuple, found["nodes"]))
    assert services.items() <= found["services"].items()
    assert found["topics"] == {name: [kind, type_hash(typestore(), kind)] for name, kind in topics.items()}
    until(lambda: "client (jazzy)" in str(discovery(SETTINGS, 0.2)), "discovery of the client")


def test_rclpy_reads_the_values_that_were_sent(client, node):
    small = [one for one in node.outputs.values() if is_in_jazzy(one.type) and "camera" not in one.name]
    small = [one for one in small if "Image" not in one.type]
    found = client.ask("read", topics={f"/{one.name}": (one.type, one.delivery.latched) for one in small})
    for one in small:
        sent, again = map(bytes.fromhex, found[f"/{one.name}"])
        read = again.ljust(len(sent), b"\0")[: len(sent)]  # rclpy returns its estimate of the size, and no padding
        assert encode(from_bytes(read, one.type)) == encode(from_bytes(sent, one.type)), one.name
    assert len(small) > 20


def test_calls_and_refusals_are_answered(client, node, live):
    found = client.ask("call", service="/lights/front", kind=SET_BOOL, times=CALLS, data=True)
    assert found["responses"] == [[True, ""]] * CALLS and live.rov.lamps["front"].on
    report(f"{CALLS} calls", found["durations_ms"])
    succeeded, message = client.ask("call", service="/undock", kind=TRIGGER, times=2)["responses"][-1]
    assert not succeeded and "not docked" in message, message


def test_all_parameters_are_listed_described_read_and_set(client, node, live):
    own, found = live.simulator.parameters, client.ask("parameters_as_they_are")
    assert [name for name, *_ in found] == list(own) and len(found) > 400
    for name, kind, text, value, reason in found:
        known = own.describe(name)
        assert value in (known.value, json.dumps(known.value)) and not reason, name
        assert known.description in text and (kind or known.value is None), name
    reasons = client.ask("set_parameters", values={"rov.friction": 0.7, SURGE: -1.0, "rov.nothing": 1})
    assert [bool(reason) for reason in reasons] == [False, True, True] and f"{SURGE} = -1" in reasons[1]
    assert own["rov.friction"] == 0.7


def test_an_incompatible_quality_of_service_is_reported(client, node):
    assert client.ask("incompatible", topic="/imu", kind="sensor_msgs/msg/Imu") == ["DURABILITY", 0]


def test_messages_arrive_and_time_goes_on_before_and_after_a_pause_and_a_reset(client, node, live):
    """At a fifth of real time, since a writer of depth 10 drops what a machine that is busy for longer has not read."""

    def press(name):
        assert client.ask("call", service=f"/simulation/{name}", kind=TRIGGER)["responses"][0][0]

    live.speed = 0.2
    client.ask("follow")
    client.ask("followed", more=FOLLOWED)
    press("pause")
    paused_ns = live.time_ns
    client.ask("call", service="/lights/front", kind=SET_BOOL, times=3, data=True)
    assert live.time_ns == paused_ns
    press("resume")
    *_, before_ns = client.ask("followed", more=FOLLOWED)
    press("reset")
    clock, odometry, after_ns = client.ask("followed", more=FOLLOWED)
    live.speed = 1.0
    for times_ns in (clock, odometry):
        steps_ns = np.diff(times_ns[1:])  # the first message came at once, between two others
        (jump,) = np.flatnonzero(steps_ns < 0)
        assert times_ns[jump + 2] == 0 and len(set(np.delete(steps_ns, jump))) == 1
    assert 0 < after_ns < before_ns


def test_a_reader_that_stops_delays_nobody(client, node):
    client.ask("follow")
    os.kill(client.process.pid, signal.SIGSTOP)
    try:
        goal = node.written["odom"] + 50
        until(lambda: node.written["odom"] >= goal, "messages while a reliable reader sleeps")
    finally:
        os.kill(client.process.pid, signal.SIGCONT)
    client.ask("followed", more=FOLLOWED)


def test_the_age_of_messages_is_measured(client, node):
    report("age of a message of 8 bytes", client.ask("ages_ms", topic="/sent", count=STAMPS))


def test_the_vehicle_comes_to_rest_when_its_pilot_is_killed(pilot, node, live, caplog):
    def speed_m_s():
        return np.linalg.norm(live.rov.velocity.linear_body_m_s)

    with suppress(ValueError):  # it is not docked
        live.command("undock", vehicle="rov").result()
    pilot.send("steer")
    until(lambda: speed_m_s() > 0.2, "motion")
    pilot.process.kill()
    until(lambda: "topic 'cmd_vel': no command for 0.5 s: it is stopped" in caplog.text, "the end of its commands")
    until(lambda: speed_m_s() < 0.01, "rest")


@pytest.mark.parametrize("course", ["pool-course", "sea-course", "reef-course"])
def test_the_node_of_a_new_team_steers(tmp_path, course):
    """With the topics of the course's world, it starts, reads and commands."""
    new_team(tmp_path / "team", course)
    settings, twists = Ros2Settings(domain_id=free_domain()), []
    environment = {
        **os.environ, "ROS_DOMAIN_ID": str(settings.domain_id), "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "PYTHONPATH": "src/pilot",
    }  # fmt: skip
    words = [JAZZY / "bin/python", "-c", "from pilot.node import main; main()"]
    with LiveSimulator(load_exercise(course).model_copy(update={"seed": 3}).made_scenario()) as live:
        table = Table(live.simulator, truth=False)
        heard = {"cmd_vel": lambda live, twist: twists.append(twist)}
        channels = [replace(each, apply=heard.get(each.name, each.apply)) for each in table.channels]
        with Ros2Node(live, channels, table.services, settings):
            pipe = subprocess.PIPE
            with subprocess.Popen(words, cwd=tmp_path / "team", env=environment, stderr=pipe, text=True) as node:
                until(lambda: len(twists) > 3 or node.poll() is not None, "a command")
                node.terminate()
                assert len(twists) > 3, node.communicate()[1]
