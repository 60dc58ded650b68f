"""The ROS 2 node, as seen by another participant in the same domain."""

import socket
import subprocess
import sys
import threading
import time
from importlib.util import find_spec

import numpy as np
import pytest

from command_line import error_line, uwsim
from ros2_tools import free_domain, peer, until
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings, settings_from
from uwsim.bridges.ros2.dds import own_udp_sockets
from uwsim.bridges.ros2.graph import ENTITIES, ENTITIES_TOPIC, entities_info
from uwsim.bridges.ros2.lossy_readers import LossyReaders, default_buffer_bytes
from uwsim.bridges.ros2.qos import reader_qos
from uwsim.bridges.ros2.settings import unicast_port
from uwsim.bridges.ros2.zenoh_names import Entity
from uwsim.channels import Table, channels
from uwsim.channels.calls.rcl_parameters import value_of
from uwsim.channels.names import node_name
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode, schema, store_of
from uwsim.channels.ros.messages import default_message
from uwsim.live import LiveSimulator

TWIST = "geometry_msgs/msg/Twist"
RANGE = "sensor_msgs/msg/Range"
LATCHED = reader_qos(10, reliable=True, user_data=b"", latched=True)
SETTINGS = Ros2Settings(domain_id=free_domain())


@pytest.fixture(scope="module")
def live():
    with LiveSimulator("lake") as live:
        yield live


@pytest.fixture(scope="module")
def node(live):
    table = Table(live.simulator)
    with Ros2Node(live, table.channels, table.services, SETTINGS) as node:
        yield node


@pytest.fixture
def other(node):
    with peer(SETTINGS) as other:
        yield other


def test_a_scan_arrives_as_it_was_read(node, other):
    other.listen("scan", "sensor_msgs/msg/LaserScan", reliable=False)
    other.listen("odom", "nav_msgs/msg/Odometry")
    scan, odom = other.next("scan"), other.next("odom")
    assert scan.header.frame_id == "base_scan" and len(scan.ranges) == 513
    assert np.all(scan.ranges[np.isfinite(scan.ranges)] <= scan.range_max)
    assert odom.child_frame_id == "base_footprint" and odom.header.frame_id == "odom"


def test_the_clock_runs_and_nothing_is_read_that_nobody_hears(node, other, live):
    other.listen("clock", "rosgraph_msgs/msg/Clock")
    times = [other.next("clock").clock for _ in range(3)]
    nanoseconds = [time.sec * 1_000_000_000 + time.nanosec for time in times]
    assert nanoseconds == sorted(set(nanoseconds))
    assert nanoseconds[-1] % 10_000_000 == 0  # simulated time, published at 100 Hz
    assert "camera/front/image_raw/compressed" not in node.written


def test_a_latched_topic_comes_to_those_who_are_late(node, other):
    for _ in range(2):
        with peer(SETTINGS) as late:
            late.listen("tf_static", "tf2_msgs/msg/TFMessage", latched=True)
            frames = {transform.child_frame_id for transform in late.next("tf_static").transforms}
            assert {"odom", "base_link", "imu_link"} <= frames


def test_commands_are_logged_and_move_the_vehicle(node, other, live):
    twist = default_message("geometry_msgs/msg/Twist")
    twist.linear.x = 0.4
    other.say("undock", default_message("std_msgs/msg/Empty"))
    steering = other.writer("cmd_vel", TWIST)
    until(lambda: steering.write(encode(twist)) and live.rov.velocity.linear_body_m_s[0] > 0.2, "motion")
    assert {"undock", "set_effort"} <= {entry.name for entry in live.log}


def test_a_publisher_that_leaves_the_domain_ends_its_command(node, live):
    def forces_n() -> list[float]:
        return [entry.arguments["force_body_n"][0] for entry in live.log if entry.name == "set_wrench"]

    live.command("set_parameter", name="rov.command_timeout_s", value=1e6).result()  # rules out the timeout
    with peer(SETTINGS) as leaving:
        wrench = build.message("geometry_msgs/msg/Wrench", force=build.vector((50.0, 0.0, 0.0)))
        steering = leaving.writer("cmd_wrench", wrench.__msgtype__)
        until(lambda: steering.write(encode(wrench)) and forces_n()[-1:] == [50.0], "a force")
    until(lambda: forces_n()[-1] == 0.0, "its end")
    live.command("set_parameter", name="rov.command_timeout_s", value=0.5).result()


@pytest.fixture
def heard(other):
    """Return a function that waits until a text on /rosout contains each of some words, and returns all texts."""
    other.listen("rosout", "rcl_interfaces/msg/Log", latched=True)
    texts: list[str] = []

    def wait(*words):
        def is_complete():
            texts.extend(log.msg for log in other.heard("rosout"))
            return all(any(word in text for text in texts) for word in words)

        until(is_complete, f"{words} on /rosout")
        return texts

    return wait


def test_the_answer_of_a_call_and_the_reason_of_a_refusal_are_said_on_rosout(other, heard):
    other.say("lights/front", build.message("std_msgs/msg/Bool", data=True))
    other.say("simulation/set_speed", build.text("nonsense"))
    other.say("cmd_tilt", build.message("std_msgs/msg/Float64", data=99.0))
    heard(  # in any order: calls are answered on threads
        '/lights/front: {"success":true',
        "/simulation/set_speed: data = 'nonsense': not JSON (column 1: Expecting value)",
        "/cmd_tilt: cmd_tilt = 99.0 rad: must be in",
    )


def test_all_stop_is_set_and_released_by_a_message_and_commands_meanwhile_are_refused(other, heard, live):
    twist = default_message("geometry_msgs/msg/Twist")
    twist.linear.x = 0.4
    steering = other.writer("cmd_vel", TWIST)
    until(lambda: steering.write(encode(twist)) and live.rov.effort.any(), "efforts")
    other.say("all_stop", build.message("std_msgs/msg/Bool", data=True))
    until(lambda: live.rov.all_stopped and not live.rov.effort.any(), "all stop")
    other.say("cmd_vel", twist)
    assert "all stop is set" in str(heard("/cmd_vel: vehicle")) and not live.rov.effort.any()
    other.say("all_stop", build.message("std_msgs/msg/Bool", data=False))
    until(lambda: not live.rov.all_stopped, "its release")


def test_a_parameter_is_set_by_a_message_and_an_unknown_one_is_refused(other, heard, live):
    value = build.message("rcl_interfaces/msg/ParameterValue", type=3, double_value=44.5)
    for name in ("rov.drag.linear.surge", "rov.drag.linear.surgee"):
        other.say("set_parameter", build.message("rcl_interfaces/msg/Parameter", name=name, value=value))
    assert "/set_parameter: rov.drag.linear.surge = 44.5" in heard("surgee")
    assert live.simulator.parameters["rov.drag.linear.surge"] == 44.5
    assert "set_parameters" in {entry.name for entry in live.log}


def test_parameter_values_of_every_type_are_read():
    def value(kind, **fields):
        return value_of(build.message("rcl_interfaces/msg/ParameterValue", type=kind, **fields))

    assert value(1, bool_value=True) is True and value(2, integer_value=7) == 7
    assert value(4, string_value="sea") == "sea" and value(9, string_array_value=["a"]) == ["a"]
    assert value(8, double_array_value=np.array([1.0, 2.5])) == [1.0, 2.5]
    with pytest.raises(ValueError, match=r"value.type = 0: must be one of 1 \(bool_value\)"):
        value(0)


def test_a_namespace_is_that_of_the_node():
    info = entities_info("jazzy", bytes(16), node_name("fleet/auv_1"), [], []).node_entities_info_seq[0]
    assert (info.node_namespace, info.node_name) == ("/fleet/auv_1", "uwsim")
    token = Entity("NN", SETTINGS, "ab", 0, node_name("auv_1")).token
    assert token.split("/")[5:] == ["NN", "%", "%auv_1", "uwsim"]


def test_a_best_effort_reader_of_messages_too_large_for_its_socket_is_warned_of_once(node, other):
    size = default_buffer_bytes()
    assert size is not None and size < 640 * 480 * 4, "Linux's default"
    warned = []
    lossy = LossyReaders(warned.append)
    for has_any in (False, True, True):
        lossy.note("small", has_any)
        lossy.note("picture", has_any)
        lossy.check("small", size)
        lossy.check("picture", size + 1)
    assert len(warned) == 1 and "topic 'picture': a best-effort reader will lose messages of" in warned[0]
    writer = node._writers["imu"]
    assert not writer.has_best_effort_readers()
    other.listen("imu", "sensor_msgs/msg/Imu", reliable=False)
    until(writer.has_best_effort_readers, "the reader's quality of service")


def test_the_graph_tells_the_node_and_all_its_endpoints(node, other):
    reader = other.participant.reader(
        ENTITIES_TOPIC, ENTITIES, reader_qos(10, reliable=True, user_data=b"", latched=True)
    )
    data = until(lambda: reader.take(10), "discovery")[0]
    info = store_of("jazzy").deserialize_cdr(data, ENTITIES)
    (entry,) = info.node_entities_info_seq
    assert (entry.node_namespace, entry.node_name) == ("/", "uwsim")
    outputs = [channel for channel in node.channels if channel.direction == "out"]
    servers = len(node.services) + 6  # those of parameters
    assert len(entry.writer_gid_seq) == len(outputs) + 2 + servers  # plus /rosout and /parameter_events
    assert len(entry.reader_gid_seq) == len(node.channels) - len(outputs) + servers
    assert all(len(gid.data) == 16 for gid in entry.writer_gid_seq)


def test_humble_has_its_own_gids_and_ranges(live):
    settings = Ros2Settings("humble", domain_id=free_domain())
    with Ros2Node(live, channels(live.simulator), (), settings), peer(settings) as other:
        reader = other.participant.reader(ENTITIES_TOPIC, ENTITIES, LATCHED)
        info = store_of("humble").deserialize_cdr(until(lambda: reader.take(10), "discovery")[0], ENTITIES)
        assert len(info.gid.data) == 24
        ranges = other.participant.reader(
            "rt/altitude", "sensor_msgs/msg/Range", reader_qos(1, reliable=True, user_data=b"")
        )
        data = until(lambda: ranges.take(1), "an altitude")[0]
        assert store_of("humble").deserialize_cdr(data, "sensor_msgs/msg/Range").max_range > 0
    assert schema("sensor_msgs/msg/Range", "humble").text != schema("sensor_msgs/msg/Range").text


def test_within_this_machine_no_udp_socket_receives_from_another(node):
    """Cyclone DDS binds its sockets to 0.0.0.0 even when configured to use lo only."""
    ports = {}
    for found in own_udp_sockets():
        with found:
            address, port = found.getsockname()
            device = found.getsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, 16).rstrip(b"\0")
            ports[port] = address == "127.0.0.1" or device == b"lo"
    assert all(ports.values()) and min(ports) == unicast_port(SETTINGS.domain_id, 0)


def test_packets_that_are_not_of_dds_do_not_fill_the_log(node, other, capfd):
    """Cyclone DDS used to print a warning for each packet: 30 MB for 110,000 packets."""
    port = unicast_port(SETTINGS.domain_id, 0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        for _ in range(200):
            stranger.sendto(b"RTPS\2\5\1\x10" + bytes(12) + b"\x0c\x75" + bytes(range(60)), ("127.0.0.1", port))
    other.listen("odom", "nav_msgs/msg/Odometry")  # arrives after the packets, through the same socket
    other.next("odom")
    assert "malformed" not in capfd.readouterr().err


def test_it_leaves_within_a_second_and_leaves_no_thread(live):
    settings = Ros2Settings(domain_id=free_domain())
    before = set(threading.enumerate())
    for _ in range(2):  # the domain can be rejoined
        table = Table(live.simulator)
        node = Ros2Node(live, table.channels, table.services, settings)
        with peer(settings) as other:
            other.listen("imu", "sensor_msgs/msg/Imu")
            other.next("imu")
            began = time.monotonic()
            node.close()
            assert time.monotonic() - began < 1.0
    assert {thread for thread in set(threading.enumerate()) - before if "ros2" in thread.name} == set()


def test_settings_come_from_options_and_ros_s_variables():
    environment = {"ROS_DOMAIN_ID": "7", "ROS_DISTRO": "humble", "ROS_STATIC_PEERS": "10.0.0.2;boat"}
    assert settings_from(environment) == Ros2Settings("humble", 7, "localhost", ("10.0.0.2", "boat"))
    assert settings_from(environment, distro="jazzy", domain_id=8).domain_id == 8
    assert settings_from({"ROS_DISTRO": "noetic"}).distro == "jazzy"
    for bad in ({"ROS_DOMAIN_ID": "x"}, {"ROS_DOMAIN_ID": "233"}, {"ROS_STATIC_PEERS": "<evil>"}):
        with pytest.raises(ValueError, match="must be"):
            settings_from(bad)
    with pytest.raises(ValueError, match="reach = 'moon': must be one of localhost, subnet"):
        settings_from({}, reach="moon")
    assert "<AllowMulticast>false" in Ros2Settings().config and '"lo"' in Ros2Settings().config
    assert "<AllowMulticast>" not in Ros2Settings(reach="subnet").config


def test_importing_a_server_imports_neither_dds_nor_scipy():
    """Importing SciPy would take longer than all the rest."""
    code = (
        "import sys, uwsim, uwsim.bridges.rosbridge.server, uwsim.operator.station\n"
        "print({'cyclonedds', 'scipy'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_a_missing_extra_is_one_line_that_names_the_command(monkeypatch):
    monkeypatch.setattr(
        "uwsim.base.extras.find_spec", lambda module: None if module == "cyclonedds" else find_spec(module)
    )
    assert error_line(uwsim("serve", "lake", "--ros2")) == (
        "uwsim: error: ROS 2 needs 'cyclonedds', which is not installed: pip install 'uwsim[ros2]'"
    )
