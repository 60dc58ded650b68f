"""Actions: a vehicle flies to a pose or along a path, for clients of ROS 2 (by DDS) and of rosbridge."""

import queue
import uuid

import numpy as np
import pytest
import roslibpy
from rosbags.typesys import Stores, get_typestore

from ros2_tools import free_domain, peer, until
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.actions import ABORTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, actions_of
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings
from uwsim.channels import Table
from uwsim.channels.ros import build
from uwsim.channels.ros.action_types import FLY_PATH, NAVIGATE_TO_POSE, load_action_types
from uwsim.channels.ros.interface_types import action_texts, parsed
from uwsim.channels.ros.messages import default_message, typestore
from uwsim.channels.ros.type_hash import type_hash
from uwsim.live import LiveSimulator
from uwsim.simulator.helm import Source

SETTINGS = Ros2Settings(domain_id=free_domain())
FIBONACCI = "rob599_msgs/action/Fibonacci"
PUBLISHED = {  # hashes that rosidl and rmw_zenoh users have published
    FIBONACCI: "00bf40d6e8121f2f6fa89a9f8b78e28efc8c958cfc656f9cd7f51f223224e2a3",
    f"{FIBONACCI}_SendGoal": "3d7412ff91ff9c5abfbf9f7f5dc2171a3f32cf6da2414b2c2c82f034d176fa01",
    f"{FIBONACCI}_GetResult": "8ebe968757e1b88d729ad53e9aca6d14e4b2f113272786f55541cfb26acc91fc",
    f"{FIBONACCI}_FeedbackMessage": "a941cc541674f910f08c54c0d6a8a5a63be0ee7697a74928f342b2583dcfa88a",
    "action_msgs/srv/CancelGoal_Request": "3d3c84653c1f96918086887e1dcb236faec88b81a5b14fd4cf4840065bcdf8af",
    "action_msgs/msg/GoalStatusArray": "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
}
STATUS, CANCEL = "action_msgs/msg/GoalStatusArray", "action_msgs/srv/CancelGoal"


@pytest.fixture(scope="module")
def live():
    with LiveSimulator("pool", speed=10.0) as live:
        live.command("undock", vehicle="rov").result()
        yield live


@pytest.fixture(scope="module")
def actions(live):
    return {action.name: action for action in actions_of(live.simulator, Table(live.simulator))}


@pytest.fixture(scope="module")
def node(live, actions):
    with Ros2Node(live, [], [], SETTINGS, actions=list(actions.values())) as node:
        yield node


@pytest.fixture(scope="module")
def client(node):
    with peer(SETTINGS) as other:
        yield ActionClient(other, "navigate_to_pose", NAVIGATE_TO_POSE)


class ActionClient:
    """A client of an action, as rcl_action makes it of three services and two topics."""

    def __init__(self, other, name, kind):
        self.other, self.own, self.kind = other, f"{name}/_action", kind
        other.listen(f"{self.own}/feedback", f"{kind}_FeedbackMessage")
        other.listen(f"{self.own}/status", STATUS, latched=True)

    def send(self, goal):
        identity = build.message("unique_identifier_msgs/msg/UUID", uuid=np.frombuffer(uuid.uuid4().bytes, np.uint8))
        response = self.other.call(f"{self.own}/send_goal", f"{self.kind}_SendGoal", goal_id=identity, goal=goal)
        return identity, response.accepted

    def result(self, identity):
        return self.other.call(f"{self.own}/get_result", f"{self.kind}_GetResult", goal_id=identity)

    def cancel(self, identity=None):
        info = default_message("action_msgs/msg/GoalInfo")
        if identity is not None:
            info.goal_id = identity
        return self.other.call(f"{self.own}/cancel_goal", CANCEL, goal_info=info)

    def expect_statuses(self, *expected):
        """Wait until the last goal has passed through these; results and statuses come by topics of their own."""
        seen = []

        def arrived():
            for array in self.other.heard(f"{self.own}/status"):
                seen.extend(one.status for one in array.status_list[-1:])
            return set(expected) <= set(seen)

        until(arrived, f"statuses {expected}")
        assert seen[-1] == expected[-1]


def pose_at(point, frame_id="odom", yaw_rad=None):
    quaternion = (0.0,) * 4 if yaw_rad is None else (0.0, 0.0, np.sin(yaw_rad / 2), np.cos(yaw_rad / 2))
    return build.message(
        "geometry_msgs/msg/PoseStamped", header=build.header(0, frame_id), pose=build.pose(point, quaternion)
    )


def navigate(point, **more):
    return build.message(f"{NAVIGATE_TO_POSE}_Goal", pose=pose_at(point, **more))


def near(live, offset):
    return live.rov.pose.position_world_m + offset


def test_type_hashes_of_actions_are_the_published_ones():
    load_action_types()
    store = get_typestore(Stores.EMPTY)
    store.register(dict(typestore().fielddefs))
    store.register(parsed(action_texts(FIBONACCI, "int64 number\n", "int64[] sequence\n", "int64 progress\n")))
    assert {name: type_hash(store, name) for name in PUBLISHED} == {
        name: f"RIHS01_{digest}" for name, digest in PUBLISHED.items()
    }


def test_a_goal_is_reached_with_feedback_and_a_result(client, live):
    target = near(live, (2.0, 1.0, -0.5))
    identity, accepted = client.send(navigate(target, yaw_rad=1.0))
    assert accepted
    response = client.result(identity)
    assert (response.status, response.result.error_msg) == (SUCCEEDED, "")
    assert np.linalg.norm(live.rov.pose.position_world_m - target) < 0.11
    assert abs(live.rov.pose.yaw_rad - 1.0) < 0.06
    fed = client.other.heard(f"{client.own}/feedback")
    left = [one.feedback.distance_remaining for one in fed]
    assert all(bytes(one.goal_id.uuid) == bytes(identity.uuid) for one in fed)
    assert left[0] > left[-1] and fed[0].feedback.current_pose.header.frame_id == "odom"
    client.expect_statuses(EXECUTING, SUCCEEDED)


def test_a_goal_succeeds_within_the_tolerance_and_the_vehicle_is_held_at_the_target(client, live):
    """0.1 m at first; a wider one is reached sooner, but the vehicle goes to the target all the same."""

    def away_m(target):
        return float(np.linalg.norm(live.rov.pose.position_world_m - target))

    for tolerance_m, reached_m in ((None, 0.11), (0.5, 0.51)):
        if tolerance_m is not None:
            live.command("set_parameter", name="rov.xy_goal_tolerance", value=tolerance_m).result()
        target = near(live, (0.4, 0.0, 0.0))
        identity, _ = client.send(navigate(target))
        assert client.result(identity).status == SUCCEEDED and away_m(target) < reached_m
        until(lambda target=target: away_m(target) < 0.02, "the target")
        end_s = live.simulator.time_s + 5.0
        until(lambda end_s=end_s: live.simulator.time_s > end_s, "5 s")
        assert away_m(target) < 0.02
    live.command("reset_parameters", name="rov.xy_goal_tolerance").result()


def test_a_goal_can_be_cancelled_and_the_vehicle_comes_to_rest(client, live):
    identity, _ = client.send(navigate(near(live, (-3.0, 0.0, 0.0))))
    response = client.cancel(identity)
    assert response.return_code == 0
    assert [bytes(one.goal_id.uuid) for one in response.goals_canceling] == [bytes(identity.uuid)]
    assert client.result(identity).status == CANCELED
    client.expect_statuses(EXECUTING, CANCELING, CANCELED)
    assert client.cancel(identity).return_code == 3, "it has ended"
    assert client.cancel(default_message("unique_identifier_msgs/msg/UUID")).goals_canceling == []
    until(lambda: np.linalg.norm(live.rov.velocity.linear_body_m_s) < 0.1, "rest")


def test_a_goal_ends_when_another_command_takes_its_place(client, live, actions):
    first, _ = client.send(navigate(near(live, (3.0, 0.0, 0.0))))
    second, _ = client.send(navigate(near(live, (-3.0, 0.0, 0.0))))
    response = client.result(first)
    assert response.status == ABORTED and "another command" in response.result.error_msg
    steering = actions["navigate_to_pose"].steering
    steering.give(live, "set_effort", surge=0.25).result()
    assert client.result(second).status == ABORTED
    last = list(live.log)[-1]
    assert (last.name, last.arguments["surge"]) == ("set_effort", 0.25), "it was not brought to rest"
    steering.give(live, "set_effort").result()


def test_a_goal_ends_when_the_stations_pilot_takes_the_controls(client, live, actions):
    identity, _ = client.send(navigate(near(live, (3.0, 0.0, 0.0))))
    lease = actions["navigate_to_pose"].steering.helm.take(Source.PILOT, "Ada")
    response = client.result(identity)
    assert response.status == ABORTED
    assert response.result.error_msg.endswith("Ada has the controls, at the operator's station")
    assert not client.send(navigate(near(live, (3.0, 0.0, 0.0))))[1]
    lease.end()


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ({"point": (0.0, 0.0, 2.0)}, "above the water's surface"),
        ({"point": (0.0, 0.0, -50.0)}, "must be above the terrain, whose height there is -5.00 m"),
        ({"point": (0.0, np.nan, -2.0)}, "must be finite"),
        ({"point": (0.0, 0.0, -2.0), "frame_id": "moon"}, "frame_id = 'moon': must be odom, map or world"),
    ],
)
def test_an_impossible_goal_is_rejected_with_the_reason_in_the_log(client, goal, reason, caplog):
    assert not client.send(navigate(**goal))[1]
    assert reason in caplog.text


def test_a_docked_or_stopped_vehicle_rejects_goals(client, live, caplog):
    live.command("all_stop", vehicle="rov", on=True).result()
    assert not client.send(navigate((0.0, 0.0, -2.0)))[1]
    live.command("all_stop", vehicle="rov", on=False).result()
    assert "all stop is set" in caplog.text


def test_a_result_of_an_unknown_goal_is_unknown(client):
    unknown = build.message("unique_identifier_msgs/msg/UUID", uuid=np.ones(16, np.uint8))
    assert client.result(unknown).status == 0 and client.cancel(unknown).return_code == 2


def test_roslibpy_flies_a_path_and_cancels(live, actions):
    start, heard, fed = live.rov.pose.position_world_m, queue.SimpleQueue(), []
    poses = [
        {"pose": {"position": dict(zip("xyz", np.add(start, (0.0, y, 0.0)), strict=True))}} for y in (1.5, 0.0, 1.5)
    ]
    goal = {"path": {"header": {"frame_id": "world"}, "poses": poses}, "speed": 1.0}
    with RosbridgeServer(live, channels=[], actions=actions.values(), ros=2) as server:
        client = roslibpy.Ros("127.0.0.1", server.port)
        client.run(10.0)
        action = roslibpy.ActionClient(client, "/fly_path", FLY_PATH)
        action.send_goal(goal, heard.put, fed.append, heard.put)
        result = heard.get(timeout=180.0)
        assert result["status"].value == SUCCEEDED and result["values"]["success"]
        assert {1, 2} <= {one["leg"] for one in fed}
        identity = action.send_goal(goal, heard.put, fed.append, heard.put)
        action.cancel_goal(identity)
        ended = heard.get(timeout=180.0)
        assert ended["status"].value == CANCELED and ended["values"]["message"] == "cancelled"
        action.send_goal({"path": {}}, heard.put, fed.append, heard.put)
        assert "0 poses: must be 1 to" in str(heard.get(timeout=180.0))
        client.close()
