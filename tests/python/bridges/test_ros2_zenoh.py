"""The ROS 2 node by Zenoh, as a session sees it that does what rmw_zenoh_cpp does: its keys, tokens and attachments."""

import json
import socket
import struct
import time
from contextlib import ExitStack

import numpy as np
import pytest
import zenoh
import zenoh.ext

from listening_sockets import free_port
from ros2_tools import until
from uwsim.bridges.actions import SUCCEEDED, actions_of
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings
from uwsim.bridges.ros2.zenoh_transport import config_of
from uwsim.channels import Table
from uwsim.channels.ros import build
from uwsim.channels.ros.action_types import FLY_PATH
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.messages import default_message, from_bytes
from uwsim.live import LiveSimulator

SETTINGS = Ros2Settings(domain_id=5, rmw="zenoh")
GID = bytes(range(16))
TRIGGER = "std_srvs::srv::dds_::Trigger_/RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"
SET_BOOL = "std_srvs::srv::dds_::SetBool_/RIHS01_abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a"
LIST = (
    "rcl_interfaces::srv::dds_::ListParameters_/RIHS01_3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d"
)
TWIST = "geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"


def attachment(sequence):
    """AttachmentData::serialize_to_zbytes: zenoh-ext writes integers as they are, and an array after its length."""
    return struct.pack("<qqB16s", sequence, time.time_ns(), 16, GID)


@pytest.fixture(scope="module")
def endpoint():
    return f"tcp/127.0.0.1:{free_port()}"


def session(mode, **more):
    config = zenoh.Config()
    for key, value in {"mode": mode, "scouting/multicast/enabled": False, "timestamping/enabled": True, **more}.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


@pytest.fixture(scope="module")
def live():
    with LiveSimulator("pool") as live:
        yield live


@pytest.fixture(scope="module")
def node(live, endpoint):
    table = Table(live.simulator)
    with pytest.MonkeyPatch.context() as patch, session("router", **{"listen/endpoints": [endpoint]}):
        patch.setenv("ZENOH_CONFIG_OVERRIDE", f'connect/endpoints=["{endpoint}"]')
        actions = actions_of(live.simulator, table)
        with Ros2Node(live, table.channels, table.services, SETTINGS, actions=actions) as node:
            yield node


@pytest.fixture(scope="module")
def peer(node, endpoint):
    with session("peer", **{"connect/endpoints": [endpoint], "listen/endpoints": ["tcp/127.0.0.1:0"]}) as peer:
        yield peer


@pytest.fixture(scope="module")
def graph(peer):
    """The tokens, as a session's graph cache collects them: parts between slashes."""
    found = []
    with peer.liveliness().declare_subscriber(
        "@ros2_lv/5/**", lambda sample: found.append(str(sample.key_expr).split("/")), history=True
    ):
        until(lambda: any(parts[5] == "NN" for parts in found), "the node's token")
        yield found


def typed_in(graph, topic, kind="MP"):
    """Return type and hash of a topic of the node, as they stand in its key."""
    return until(lambda: ["/".join(one[10:12]) for one in graph if one[5:10:4] == [kind, f"%{topic}"]], topic)[0]


def token(peer, kind, topic, typed):
    """Declare what rmw_zenoh declares for an endpoint, so that the node knows it."""
    return peer.liveliness().declare_token(
        f"@ros2_lv/5/{peer.zid()}/0/1/{kind}/%/%/tester/%{topic}/{typed}/::,10:,:,:,,"
    )


def call(peer, service, typed, request):
    """ClientData::send_request: a query to all complete queryables, without consolidation."""
    key = f"5/{service}/{typed}"

    def ask():
        how = {"target": zenoh.QueryTarget.ALL_COMPLETE, "consolidation": zenoh.ConsolidationMode.NONE}
        return list(peer.get(key, payload=bytes(encode(request)), attachment=attachment(7), timeout=10.0, **how))

    (reply,) = until(ask, f"/{service}")
    assert struct.unpack("<qqB16s", reply.ok.attachment.to_bytes())[0::2] == (7, 16)
    assert reply.ok.attachment.to_bytes()[17:] == GID and str(reply.ok.key_expr) == key
    return from_bytes(reply.ok.payload.to_bytes(), request.__msgtype__.replace("_Request", "_Response"))


def test_the_graph_has_the_node_and_its_endpoints_by_their_tokens(graph):
    def found():
        return {(parts[5], *parts[8:]) for parts in graph}

    expected = {
        ("NN", "uwsim"),
        ("SS", "uwsim", "%release", *TRIGGER.split("/"), "::,10:,:,:,,"),
        ("SS", "uwsim", "%uwsim%list_parameters", *LIST.split("/"), "::,10:,:,:,,"),
        ("MS", "uwsim", "%cmd_vel", *TWIST.split("/"), "2::,10:,:,:,,"),
        ("MP", "uwsim", "%tf_static", *typed_in(graph, "tf_static").split("/"), ":1:,1:,:,:,,"),
    }
    until(lambda: expected <= found(), "all tokens")


def test_services_and_parameters_respond_to_a_query(peer, live):
    assert call(peer, "lights/front", SET_BOOL, build.message("std_srvs/srv/SetBool_Request", data=True)).success
    assert live.rov.lamps["front"].on
    listed = call(peer, "uwsim/list_parameters", LIST, default_message("rcl_interfaces/srv/ListParameters_Request"))
    assert listed.result.names == list(live.simulator.parameters)


def test_an_action_has_its_keys_and_its_goal_a_result(peer, live, graph):
    own, fed = "fly_path/_action", []
    found = {one[9]: "/".join(one[10:12]) for one in graph if one[5] != "NN" and one[9].startswith("%fly_path")}
    assert sorted(name.rpartition("%")[2] for name in found) == [
        "cancel_goal", "feedback", "get_result", "send_goal", "status",
    ]  # fmt: skip
    kinds = {name.rpartition("%")[2]: typed for name, typed in found.items()}
    assert kinds["send_goal"].startswith("uwsim_msgs::action::dds_::FlyPath_SendGoal_/RIHS01_")
    call(peer, "undock", TRIGGER, default_message("std_srvs/srv/Trigger_Request"))
    sent = default_message(f"{FLY_PATH}_SendGoal_Request")
    at = build.pose(np.add(live.rov.pose.position_world_m, (0.0, 0.0, -0.2)), (0.0, 0.0, 0.0, 0.0))
    sent.goal.path.poses = [build.message("geometry_msgs/msg/PoseStamped", pose=at)]
    asked = build.message(f"{FLY_PATH}_GetResult_Request", goal_id=sent.goal_id)
    with peer.declare_subscriber(f"5/{own}/status/{kinds['status']}", fed.append):
        assert call(peer, f"{own}/send_goal", kinds["send_goal"], sent).accepted
        response = call(peer, f"{own}/get_result", kinds["get_result"], asked)
        assert response.status == SUCCEEDED and response.result.success
        until(lambda: len(fed) == 3, "the goal's statuses, which may arrive after its result")
        arrays = [from_bytes(one.payload.to_bytes(), "action_msgs/msg/GoalStatusArray") for one in fed]
        assert [array.status_list[-1].status for array in arrays] == [1, 2, SUCCEEDED]


def test_a_topic_is_read_while_a_subscription_is_announced_and_numbers_its_messages(node, peer, graph):
    typed, found = typed_in(graph, "odom"), []
    with peer.declare_subscriber(f"5/odom/{typed}", found.append):
        time.sleep(0.2)
        assert not node.is_read("odom") and not found
        interest = token(peer, "MS", "odom", typed)
        until(lambda: len(found) > 2, "odometry")
        interest.undeclare()
        until(lambda: not node.is_read("odom"), "the end of reading")
    numbers = [struct.unpack("<qqB16s", one.attachment.to_bytes())[0] for one in found]
    assert numbers[:3] == [1, 2, 3]
    assert from_bytes(found[0].payload.to_bytes(), "nav_msgs/msg/Odometry").header.frame_id == "odom"


def test_a_late_subscription_receives_a_latched_message(peer, graph):
    typed = typed_in(graph, "tf_static")
    interest = token(peer, "MS", "tf_static", typed)
    time.sleep(0.2)
    found = []
    history = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=10)
    with zenoh.ext.declare_advanced_subscriber(
        peer, f"5/tf_static/{typed}", found.append, history=history, subscriber_detection=True
    ):
        until(lambda: found, "the transforms")
    assert from_bytes(found[0].payload.to_bytes(), "tf2_msgs/msg/TFMessage").transforms
    interest.undeclare()


def test_commands_arrive_and_end_with_their_publisher(peer, live, graph):
    def forces_n():
        return [entry.arguments["force_body_n"][0] for entry in live.log if entry.name == "set_wrench"]

    live.command("set_parameter", name="rov.command_timeout_s", value=1e6).result()  # rules out the timeout
    call(peer, "undock", TRIGGER, default_message("std_srvs/srv/Trigger_Request"))
    wrench = bytes(encode(build.message("geometry_msgs/msg/Wrench", force=build.vector((50.0, 0.0, 0.0)))))
    typed = typed_in(graph, "cmd_wrench", "MS")
    source = token(peer, "MP", "cmd_wrench", typed)
    until(
        lambda: peer.put(f"5/cmd_wrench/{typed}", wrench, attachment=attachment(1)) or forces_n()[-1:] == [50.0], "it"
    )
    source.undeclare()
    until(lambda: forces_n()[-1] == 0.0, "its end")


def test_without_a_router_the_start_says_so(live, monkeypatch):
    monkeypatch.setenv("ZENOH_CONFIG_OVERRIDE", 'connect/endpoints=["tcp/127.0.0.1:1"]')
    with pytest.warns(UserWarning, match="no Zenoh router answers: start one"):
        Ros2Node(live, [], [], SETTINGS).close()


def test_silent_connections_shut_out_no_session(monkeypatch):
    port = free_port()
    endpoints = f'["tcp/127.0.0.1:{port}"]'
    monkeypatch.setenv("ZENOH_CONFIG_OVERRIDE", f"listen/endpoints={endpoints};connect/endpoints=[]")
    with zenoh.open(config_of(SETTINGS)), ExitStack() as stack:
        for _ in range(150):
            stack.enter_context(socket.create_connection(("127.0.0.1", port)))
        client = {"connect/endpoints": json.loads(endpoints), "connect/timeout_ms": 4000}
        with session("client", **client):  # which raises an error if it is not served
            pass
