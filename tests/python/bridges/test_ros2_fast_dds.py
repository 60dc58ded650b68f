"""ROS 2 with its default middleware: Fast DDS and Fast CDR read our messages, and we read theirs."""

import os
import signal
import time
import zlib

import numpy as np
import pytest

from channel_tools import stamp_ns
from fast_dds import BINARY, fast_dds_peer, sub
from ros2_tools import free_domain, peer, until
from uwsim.bridges.actions import actions_of
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings, rtps, rtps_participant
from uwsim.bridges.ros2.graph import ENTITIES, ENTITIES_TOPIC
from uwsim.bridges.ros2.qos import reader_qos
from uwsim.channels import Channel, Table, channels
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.ros import build
from uwsim.channels.ros.action_types import FLY_PATH
from uwsim.channels.ros.cdr import encode, schema, store_of
from uwsim.channels.ros.messages import default_message, from_bytes
from uwsim.live import LiveSimulator

pytestmark = pytest.mark.skipif(not BINARY.is_file(), reason="fast_dds_peer is built by tools/setup --dev")
SCAN, CLOUD, TF = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2", "tf2_msgs/msg/TFMessage"
IMAGE, TWIST, ODOMETRY = "sensor_msgs/msg/Image", "geometry_msgs/msg/Twist", "nav_msgs/msg/Odometry"
MESSAGES = 40
RCL = "rcl_interfaces::srv::dds_::"


@pytest.fixture(scope="module")
def live():
    with LiveSimulator("lake") as live:
        yield live


@pytest.fixture
def settings():
    return Ros2Settings(domain_id=free_domain())


def type_of(other, topic):
    """Return the type of the first endpoint of a topic, as soon as Fast DDS has discovered one."""
    return until(lambda: [one["type"] for one in other.endpoints().values() if one["topic"] == topic], topic)[0]


def test_calls_as_rmw_fastrtps_makes_them_are_answered_even_in_fragments(live, settings, monkeypatch):
    monkeypatch.setattr(rtps, "FRAGMENT", 4000)
    services = {"uwsim/list_parameters": f"{RCL}ListParameters", "simulation/resume": "std_srvs::srv::dds_::Trigger"}
    words = [word for name, kind in services.items() for word in ("call", name, kind, "3")]
    with (
        Ros2Node(live, [], Table(live.simulator).services, settings) as node,
        fast_dds_peer(settings.domain_id, "graph", *words) as other,
    ):
        for name in services:
            answers = until(lambda: len(found := other.answers(name)) == 3 and found, name)  # noqa: B023
            assert all(answer["is_answer_of_last"] for answer in answers)
            if name == "uwsim/list_parameters":
                data = bytes.fromhex(answers[-1]["hex"])
                listed = from_bytes(data, "rcl_interfaces/srv/ListParameters_Response").result.names
                assert len(data) > 3 * rtps.FRAGMENT and listed == list(live.simulator.parameters)
        assert type_of(other, f"rr/{node.name}/get_parametersReply") == f"{RCL}GetParameters_Response_"


def test_an_action_of_rmw_fastrtps_ends_with_a_result(live, settings):
    """A goal that is rejected, since the vehicle is docked, and a result that is unknown: one response each."""
    kind, own = "uwsim_msgs::action::dds_::FlyPath", "fly_path/_action"
    actions = actions_of(live.simulator, Table(live.simulator))
    goal = bytes(encode(default_message(f"{FLY_PATH}_SendGoal_Request"))).hex()
    asked = bytes(encode(default_message(f"{FLY_PATH}_GetResult_Request"))).hex()
    words = ["call", f"{own}/send_goal", f"{kind}_SendGoal", goal]
    words += ["call", f"{own}/get_result", f"{kind}_GetResult", asked]
    status = ["sub", f"rt/{own}/status", "action_msgs::msg::dds_::GoalStatusArray_", "reliable", "latched"]
    with (
        Ros2Node(live, [], [], settings, actions=actions),
        fast_dds_peer(settings.domain_id, "graph", *words, *status) as other,
    ):
        responses = [until(lambda: other.answers(f"{own}/{name}"), name) for name in ("send_goal", "get_result")]  # noqa: B023
        sent, found = (bytes.fromhex(one[0]["hex"]) for one in responses)
        assert not from_bytes(sent, f"{FLY_PATH}_SendGoal_Response").accepted
        assert from_bytes(found, f"{FLY_PATH}_GetResult_Response").status == 0
        feedback, cancel = f"rt/{own}/feedback", f"rq/{own}/cancel_goalRequest"
        assert type_of(other, feedback) == f"{kind}_FeedbackMessage_"
        assert type_of(other, cancel) == "action_msgs::srv::dds_::CancelGoal_Request_"


def test_a_server_that_leaves_is_unmatched_at_once(live, settings, monkeypatch):
    monkeypatch.setattr(rtps_participant, "LEASE_S", 1000)
    services = [service for service in Table(live.simulator).services if service.name == "dock"]
    words = ["sub", "rr/dockReply", "std_srvs::srv::dds_::Trigger_Response_", "reliable", "volatile"]
    with fast_dds_peer(settings.domain_id, *words) as other:

        def counts():
            return [line["count"] for line in list(other.lines) if "matched" in line]

        with Ros2Node(live, [], services, settings):
            until(lambda: counts() == [1], "a match")
        until(lambda: counts() == [1, 0], "its end")


def test_fast_dds_reads_the_values_that_were_sent(live, settings):
    table, feed = Table(live.simulator), Feed(live)
    sent: dict[str, list] = {"rt/scan": [], "rt/laserPointCloud": []}
    with Ros2Node(live, table.channels, table.services, settings, feed=feed):
        for channel in table.channels:
            if f"rt/{channel.name}" in sent:
                feed.listen(channel, sent[f"rt/{channel.name}"].append)
        words = [*sub("scan", SCAN), *sub("laserPointCloud", CLOUD), *sub("tf_static", TF, "reliable", "latched")]
        with fast_dds_peer(settings.domain_id, *words) as other:
            for topic, readings in sent.items():
                received = other.wait_for(topic, MESSAGES)
                checksums = iter([zlib.crc32(reading.cdr) for reading in readings])
                assert all(line["crc32"] in checksums for line in received), topic  # all were sent, in this order
            latched = other.wait_for("rt/tf_static", 1)
            assert {"odom", "base_link"} <= set(latched[0]["children"])
            decoded = other.messages("rt/scan")[-1]
    scans = {stamp_ns(reading.message): reading.message for reading in sent["rt/scan"]}
    scan = scans[decoded["stamp_ns"]]
    assert decoded["frame_id"] == scan.header.frame_id and decoded["count"] == len(scan.ranges)
    assert decoded["sum"] == pytest.approx(np.sum(scan.ranges[np.isfinite(scan.ranges)], dtype=float), rel=1e-12)
    assert decoded["angle_min"] == pytest.approx(scan.angle_min, rel=1e-6)


def test_the_graph_names_endpoints_that_fast_dds_has_found_with_their_types_hashes(live, settings):
    latched, table = reader_qos(1, reliable=True, user_data=b"", latched=True), Table(live.simulator)
    with (
        Ros2Node(live, table.channels, table.services, settings) as node,
        fast_dds_peer(settings.domain_id, "graph") as other,
        peer(settings) as ours,
    ):
        reader = ours.participant.reader(ENTITIES_TOPIC, ENTITIES, latched)
        data = until(lambda: reader.take(1), "discovery")[0]
        (entry,) = store_of("jazzy").deserialize_cdr(data, ENTITIES).node_entities_info_seq
        told = {bytes(gid.data).hex() for gid in (*entry.reader_gid_seq, *entry.writer_gid_seq)}
        until(lambda: told <= other.endpoints().keys(), "discovery by Fast DDS")
        found = {line["topic"]: line for guid, line in other.endpoints().items() if guid in told}
        for channel in node.channels:
            package, _, short = channel.type.split("/")
            line = found[f"rt/{channel.name}"]
            assert line["type"] == f"{package}::msg::dds_::{short}_"
            assert line["user_data"] == f"typehash={schema(channel.type).type_hash};"


def test_commands_of_fast_dds_arrive_in_order(live, settings):
    heard: list[float] = []
    channel = Channel("cmd_vel", TWIST, "in", "", apply=lambda live, message: heard.append(message.linear.x))
    with Ros2Node(live, [channel], (), settings), fast_dds_peer(settings.domain_id, "pub", "rt/cmd_vel", "20"):
        until(lambda: len(heard) >= MESSAGES, "commands")
    counts = np.round(1e3 * np.array(heard)).astype(int)
    assert np.all(np.diff(counts) > 0)
    assert len(counts) >= 0.95 * (counts[-1] - counts[0] + 1)


def test_a_reader_that_stops_delays_nobody(live, settings):
    """Messages beyond the history depth are lost; another reader receives all of them, and closing does not block."""
    picture = build.message(IMAGE, data=np.zeros(1_000_000, np.uint8))
    table = [
        Channel("picture", IMAGE, "out", "", rate_hz=20.0, read=lambda sim: picture),
        Channel("odometry", ODOMETRY, "out", "", rate_hz=50.0, read=channel_named(live, "odom").read),
    ]
    with Ros2Node(live, table, (), settings) as node, peer(settings) as ours:
        ours.listen("odometry", ODOMETRY)
        with fast_dds_peer(settings.domain_id, *sub("picture", IMAGE), *sub("odometry", ODOMETRY)) as other:
            other.wait_for("rt/picture", 2)
            os.kill(other.process.pid, signal.SIGSTOP)
            try:
                ours.heard("odometry")
                before = dict(node.written)
                until(lambda: node.written["picture"] >= before["picture"] + 20, "pictures while one reader sleeps")
                assert len(ours.heard("odometry")) >= 20
                began = time.monotonic()
                node.close()
                assert time.monotonic() - began < 5.0  # takes 2 ms on an idle machine
            finally:
                os.kill(other.process.pid, signal.SIGCONT)
    assert node.written["odometry"] > before["odometry"]


def channel_named(live, name):
    return next(channel for channel in channels(live.simulator) if channel.name == name)
