"""joint_trajectory and FollowJointTrajectory: an arm follows points, by rosbridge and ROS 2, or the goal is refused."""

import queue
import time
import uuid
from typing import Any

import numpy as np
import pytest
import roslibpy
from scipy.interpolate import CubicHermiteSpline

from ros2_tools import free_domain, peer
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.actions import ABORTED, CANCELED, SUCCEEDED, JointAction, accepted, actions_of
from uwsim.bridges.ros2 import Ros2Node, Ros2Settings
from uwsim.channels import Table
from uwsim.channels.authority.joint_motion import Point, trajectory_of
from uwsim.channels.ros import build
from uwsim.channels.ros.action_types import FOLLOW_JOINTS
from uwsim.channels.ros.messages import default_message
from uwsim.live import LiveSimulator, replay
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

ACTION, TOPIC = "arm_controller/follow_joint_trajectory", "arm_controller/joint_trajectory"
SETTINGS = Ros2Settings(domain_id=free_domain())
ROV = {"name": "rov", "model": "bluerov2_heavy_alpha5", "start": {"position_m": [0, 0, -5]}}
TERRAIN = {"source": "noise", "size_m": [60, 60], "spacing_m": 1, "bed_depth_m": 15, "hill_height_m": 0}


@pytest.fixture(scope="module")
def live():
    scenario = validated(Scenario, {"name": "site", "terrain": TERRAIN, "vehicles": [ROV]})
    with LiveSimulator(scenario, speed=10.0) as live:
        yield live


@pytest.fixture(scope="module")
def table(live):
    return Table(live.simulator)


@pytest.fixture(scope="module")
def action(live, table) -> JointAction:
    return next(one for one in actions_of(live.simulator, table) if one.name == ACTION)


def trajectory(points: dict[float, Any], joints=("shoulder", "upperarm"), **fields: Any) -> Any:
    """Return a message. points: positions by time, or with the velocities behind them."""
    found = [
        build.message(
            "trajectory_msgs/msg/JointTrajectoryPoint", time_from_start=build.duration(at),
            **{name: np.array(each, float) for name, each in zip(("positions", "velocities"), values, strict=False)},
        )
        for at, values in points.items()
    ]  # fmt: skip
    return build.message("trajectory_msgs/msg/JointTrajectory", joint_names=list(joints), points=found, **fields)


def goal_of(points: dict[float, Any], **fields: Any) -> Any:
    goal = default_message(f"{FOLLOW_JOINTS}_Goal")
    goal.trajectory = trajectory(points)
    for name, value in fields.items():
        setattr(goal, name, value)
    return goal


class Followed:
    """A goal's feedback and its end."""

    def __init__(self, live, action, goal):
        self.fed: list[Any] = []
        self._ends: queue.Queue[Any] = queue.Queue()
        self.goal = accepted(live, action, goal, self.fed.append, lambda *end: self._ends.put(end))
        self.goal.start()

    def end(self):
        return self._ends.get(timeout=180.0)


def test_the_joints_follow_the_points_and_arrive(live, action):
    followed = Followed(live, action, goal_of({2.0: [[0.4, 0.8]], 3.0: [[0.6, 1.1]], 4.0: [[0.3, 1.0]]}))
    status, result = followed.end()
    assert (status, result.error_code, result.error_string) == (SUCCEEDED, 0, "")
    assert live.simulator.rov.arm.read().positions[:2] == pytest.approx([0.3, 1.0], abs=0.02)
    errors = np.array([one.error.positions for one in followed.fed])
    assert np.abs(errors).max() < 0.05  # the speed of a command, up to 0.4 rad/s, is 0.02 s old, and its motor late
    assert max(one.desired.positions[0] for one in followed.fed) == pytest.approx(0.6, abs=0.03)


def test_between_points_with_speeds_the_path_is_the_cubic_of_hermite(action):
    message = trajectory({1.0: [[0.5, 1.0], [0.2, 0.0]], 3.0: [[0.7, 1.5], [0.0, -0.1]]})
    path = trajectory_of(message, action.source, action.limits)
    curve = path.from_state(Point(np.array([0.1, 0.9]), np.zeros(2)), 0.0)
    spline = CubicHermiteSpline([0, 1, 3], [[0.1, 0.9], [0.5, 1.0], [0.7, 1.5]], [[0, 0], [0.2, 0.0], [0.0, -0.1]])
    for at_s in (0.0, 0.3, 1.0, 2.2, 3.0):
        assert curve(at_s).positions == pytest.approx(spline(at_s), abs=1e-12)
        assert curve(at_s).speeds == pytest.approx(spline(at_s, 1), abs=1e-12)


def test_a_path_faster_than_its_motors_breaks_its_tolerance(live, action):
    tolerance = build.message("control_msgs/msg/JointTolerance", name="shoulder", position=0.1)
    start = live.simulator.rov.arm.read().positions[0]
    status, result = Followed(live, action, goal_of({0.5: [[start + 2.0, 1.1]]}, path_tolerance=[tolerance])).end()
    assert (status, result.error_code) == (ABORTED, -4)
    assert "shoulder" in result.error_string


def test_a_goal_that_is_cancelled_stops_where_it_is(live, action):
    followed = Followed(live, action, goal_of({20.0: [[1.5, 1.1]]}))
    time.sleep(0.3)
    followed.goal.cancel()
    status, result = followed.end()
    assert (status, result.error_string) == (CANCELED, "cancelled")
    with live.mission_clock() as clock:
        clock.wait(0.5)
    assert abs(live.simulator.rov.arm.read().speeds[0]) < 1e-3


def test_another_command_of_the_joints_replaces_a_goal(live, action, table):
    followed = Followed(live, action, goal_of({20.0: [[1.5, 1.1]]}))
    channel = next(one for one in table.channels if one.name == "cmd_joints")
    channel.apply(live, build.message("sensor_msgs/msg/JointState", name=["shoulder"], velocity=np.zeros(1)))
    status, result = followed.end()
    assert status == ABORTED
    assert result.error_string


def test_a_direct_command_of_its_joints_ends_a_goal(live, action):
    followed = Followed(live, action, goal_of({30.0: [[1.0, 1.5]]}))
    time.sleep(0.3)
    live.rov.set_joints(positions={"wrist": 0.1})  # of another joint: no matter
    time.sleep(0.3)
    live.rov.set_joints(positions={"shoulder": -0.2})
    status, result = followed.end()
    assert status == ABORTED
    assert "another command" in result.error_string
    with live.mission_clock() as clock:
        clock.wait(8.0)
    assert live.simulator.rov.arm.read().positions[0] == pytest.approx(-0.2, abs=0.02)


def test_all_stop_ends_a_goal_and_refuses_the_next(live, action):
    followed = Followed(live, action, goal_of({20.0: [[1.5, 1.1]]}))
    live.command("all_stop", vehicle="rov", on=True).result()
    try:
        status, result = followed.end()
        assert (status, result.error_string) == (ABORTED, "all stop is set")
        with pytest.raises(ValueError, match="all stop is set"):
            Followed(live, action, goal_of({1.0: [[0.5, 1.1]]}))
    finally:
        live.command("all_stop", vehicle="rov", on=False).result()


@pytest.mark.parametrize(
    ("message", "rule"),
    [
        (trajectory({1.0: [[0.5]]}), r"points\[0\].positions"),
        (trajectory({1.0: [[0.5, 9.0]]}), "upperarm = 9: must be in"),
        (trajectory({1.0: [[0.5, np.nan]]}), "finite"),
        (trajectory({1.0: [[0.5]]}, ["jaw"]), "jaw: must be one of shoulder"),
        (trajectory({1.0: [[0.5, 0.5]]}, ["wrist", "wrist"]), "different joints"),
        (trajectory({}), "points: 0"),
        (trajectory({2.0: [[0.5, 0.5]], 1.0: [[0.5, 0.5]]}), "must be positive, increase"),
        (trajectory({2.0: []}), "positions: must be given"),
    ],
)
def test_what_cannot_be_followed_is_refused(live, table, message, rule):
    channel = next(one for one in table.channels if one.name == TOPIC)
    with pytest.raises(ValueError, match=rule):
        channel.apply(live, message)


def test_what_a_trajectory_did_is_repeated_from_the_log():
    scenario = validated(Scenario, {"name": "site", "terrain": TERRAIN, "vehicles": [ROV]})
    with LiveSimulator(scenario, speed="max", paused=True) as live:
        channel = next(one for one in Table(live.simulator).channels if one.name == TOPIC)
        channel.apply(live, trajectory({1.0: [[0.3, 1.2]]}))
        live.resume()
        while live.simulator.time_s < 3.0:
            time.sleep(0.01)
        live.pause()
        state, tick, log = live.simulator.save_state(), live.simulator.tick, live.log
        assert live.simulator.rov.arm.read().positions[0] == pytest.approx(0.3, abs=0.02)
    assert replay(scenario, log, tick).save_state() == state


def test_by_ros_2(live, action):
    with Ros2Node(live, [], [], SETTINGS, actions=[action]), peer(SETTINGS) as other:
        identity = build.message("unique_identifier_msgs/msg/UUID", uuid=np.frombuffer(uuid.uuid4().bytes, np.uint8))
        own = f"{ACTION}/_action"
        goal = goal_of({1.0: [[0.3, 1.2]]})
        assert other.call(f"{own}/send_goal", f"{FOLLOW_JOINTS}_SendGoal", goal_id=identity, goal=goal).accepted
        response = other.call(f"{own}/get_result", f"{FOLLOW_JOINTS}_GetResult", goal_id=identity)
        assert (response.status, response.result.error_code) == (SUCCEEDED, 0)


def test_by_rosbridge(live):
    with RosbridgeServer(live, port=0) as server:
        client = roslibpy.Ros(host="127.0.0.1", port=server.port)
        client.run()
        try:
            act = roslibpy.ActionClient(client, f"/{ACTION}", FOLLOW_JOINTS)
            ends: queue.Queue[Any] = queue.Queue()
            points = [{"positions": [0.5, 1.0], "time_from_start": {"sec": 1, "nanosec": 0}}]
            goal = {"trajectory": {"joint_names": ["shoulder", "upperarm"], "points": points}}
            act.send_goal(roslibpy.Goal(goal), ends.put, lambda feedback: None, ends.put)
            end = ends.get(timeout=180.0)
            assert end["status"].value == SUCCEEDED
            assert end["values"]["error_code"] == 0
        finally:
            client.close()
