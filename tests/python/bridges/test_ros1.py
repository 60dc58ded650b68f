"""The simulator as a ROS 1 node, tested with Debian's rospy, tf2 and laser_geometry."""

import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from command_line import error_line, uwsim
from forked_programs import Programs
from ros1_tools import master, ros_is_installed, run_node
from uwsim import Simulator, recording
from uwsim.bridges.ros1.raw_types import read_message
from uwsim.channels.ros.build import message
from uwsim.channels.ros.message_types import ros1_typestore
from uwsim.channels.ros.messages import to_bytes
from uwsim.recording import Recorder
from uwsim.recording.survey_from import live_map
from uwsim.simulator.helm import STOPPED

NODE = ("--ros1", "--port", "0")
pytestmark = pytest.mark.skipif(not ros_is_installed(), reason="Debian's packages of ROS 1 are not installed")


@pytest.fixture(scope="module")
def ros(tmp_path_factory: pytest.TempPathFactory, programs: Programs) -> Iterator[dict[str, str]]:
    with (
        master(tmp_path_factory.mktemp("ros")) as environment,
        programs.greeted("serve", "pool", "--seed", "3", *NODE, env=environment),
    ):
        yield environment


SEE = """
import json, rospy, tf2_ros, sys
from laser_geometry import LaserProjection
from sensor_msgs import point_cloud2
from sensor_msgs.msg import LaserScan, PointCloud2
from std_msgs.msg import String
from geometry_msgs.msg import Pose
rospy.init_node("test", anonymous=True)
found = {}
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
found["types"] = dict(rospy.get_published_topics())
found["depthArray"] = rospy.wait_for_message("/depthArray", String, 60).data
found["modelTrigger"] = rospy.wait_for_message("/modelTrigger", String, 60).data
found["propPos"] = rospy.wait_for_message("/propPos", Pose, 60).position.z
scans, clouds = {}, {}
def keep(kept):
    return lambda m: kept.setdefault(m.header.stamp.to_nsec(), m)
rospy.Subscriber("/scan", LaserScan, keep(scans)), rospy.Subscriber("/laserPointCloud", PointCloud2, keep(clouds))
import time
until = time.time() + 60
while not set(scans) & set(clouds) and time.time() < until:
    time.sleep(0.05)
stamp = min(set(scans) & set(clouds))
scan = scans[stamp]
projected = LaserProjection().projectLaser(scan)
found["frame"] = scan.header.frame_id
found["counts"] = [m.header.seq for m in scans.values()]
found["theirs"] = [list(map(float, p)) for p in point_cloud2.read_points(projected, ("x", "y", "z"))]
found["ours"] = [list(map(float, p)) for p in point_cloud2.read_points(clouds[stamp], ("x", "y", "z"))]
tree = ("world", "odom", "base_footprint", "base_link", "base_scan")
for parent, child in zip(tree, tree[1:]):
    moved = buffer.lookup_transform(parent, child, rospy.Time(0), rospy.Duration(30)).transform
    found[parent + ">" + child] = [moved.translation.x, moved.translation.y, moved.translation.z]
name = "/robot_description"
found["vehicle"] = [rospy.get_param(name), rospy.wait_for_message(name, String, 30).data]
print(json.dumps(found))
"""


def test_rospy_tf2_and_laser_geometry_see_what_the_paper_publishes(ros: dict[str, str]) -> None:
    found = json.loads(run_node(SEE, ros))
    assert found["types"].items() >= {
        "/scan": "sensor_msgs/LaserScan", "/tf": "tf2_msgs/TFMessage", "/octomap_binary": "octomap_msgs/Octomap"
    }.items()  # fmt: skip
    # The published decoder expects the letter a after every number, of which there are 513 or 1025.
    ranges = found["depthArray"].split("a")
    assert ranges.pop() == "" and len(ranges) == 513 and all(0.0 < float(r) <= 55.0 for r in ranges)
    assert found["counts"] == list(range(found["counts"][0], found["counts"][0] + len(found["counts"])))
    assert found["vehicle"][0] == found["vehicle"][1] and '<link name="base_scan"' in found["vehicle"][0]
    docked_m = Simulator("pool").rov.pose.position_world_m[2]
    assert found["modelTrigger"] == "2" and found["propPos"] == pytest.approx(docked_m, abs=0.1)
    # The paper's figure 10: odom -> base_footprint -> base_link -> base_scan.
    assert found["base_footprint>base_link"] == [0.0, 0.0, 0.0] and found["odom>base_footprint"][2] == found["propPos"]
    assert found["frame"] == "base_scan" and found["base_link>base_scan"][0] > 0.3
    ours, theirs = np.array(found["ours"]), np.array(found["theirs"])
    assert ours.shape == theirs.shape and len(ours) > 20
    np.testing.assert_allclose(ours, theirs, atol=2e-5)


LENGTH_M, SPACING_M, LANES = 5.0, 2.5, 3

MOW = """
import json, math, sys, threading, time
import rospy
from geometry_msgs.msg import Pose, Twist
from std_msgs.msg import Float64, String
from tf2_msgs.msg import TFMessage
rospy.init_node("mower")
length, spacing, lanes = map(float, sys.argv[1:])
news, track = threading.Condition(), []
class Vehicle:
    stamp_s = -1.0
def look(m):
    (found,) = [t for t in m.transforms if t.child_frame_id == "base_footprint"]
    p, q = found.transform.translation, found.transform.rotation
    with news:
        Vehicle.stamp_s, Vehicle.x, Vehicle.y = found.header.stamp.to_sec(), p.x, p.y
        Vehicle.yaw = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
        news.notify()
def reached(stamp_s):
    with news:
        return news.wait_for(lambda: Vehicle.stamp_s > stamp_s - 0.001, 60.0)
rospy.Subscriber("/tf", TFMessage, look)
steer = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
step = rospy.Publisher("/simulation/step", String, queue_size=1)
tilt = rospy.Publisher("/cmd_tilt", Float64, queue_size=1, latch=True)
release = rospy.Publisher("/key", Pose, queue_size=1, latch=True)
key = Pose()
key.orientation.w = 1
release.publish(key)
tilt.publish(1.5)
while min(p.get_num_connections() for p in (steer, step, tilt, release)) == 0:
    time.sleep(0.02)
def advance(seconds):
    # Simulated time waits for this node: however busy the machine is, the flight is the same.
    wanted = max(Vehicle.stamp_s, 0.0) + seconds
    while True:
        step.publish(json.dumps({"steps": round(seconds / 0.005)}))
        if reached(wanted):
            return
def fly_to(x, y):
    while math.hypot(x - Vehicle.x, y - Vehicle.y) > 0.6:
        if Vehicle.stamp_s > 300.0:
            raise SystemExit("lost: %s" % track[-1])
        turn = (math.atan2(y - Vehicle.y, x - Vehicle.x) - Vehicle.yaw + math.pi) % (2 * math.pi) - math.pi
        command = Twist()
        command.linear.x = 1.0 if abs(turn) < 0.3 else 0.0
        command.angular.z = max(-0.6, min(0.6, 1.2 * turn))
        steer.publish(command)
        advance(0.2)
        track.append((Vehicle.x, Vehicle.y))
advance(0.2)
x0, y0, ahead = Vehicle.x, Vehicle.y, (math.cos(Vehicle.yaw), math.sin(Vehicle.yaw))
def place(along, left):
    return x0 + along * ahead[0] - left * ahead[1], y0 + along * ahead[1] + left * ahead[0]
fly_to(*place(3.0, 0.0))
del track[:]
for lane in range(int(lanes)):
    ends = [place(3.0, lane * spacing), place(3.0 + length, lane * spacing)]
    for end in ends[:: 1 if lane % 2 == 0 else -1]:
        fly_to(*end)
corners = [place(3.0, 0.0), place(3.0 + length, 0.0), place(3.0, (lanes - 1) * spacing)]
print(json.dumps({"track": track, "corners": corners, "stamp_s": Vehicle.stamp_s, "ros_s": rospy.get_time()}))
"""


def test_a_lawn_mower_written_as_a_rospy_node_flies_the_scenario(tmp_path: Path, programs: Programs) -> None:
    """The vehicle leaves the dock and flies three lanes; the track and the map then cover the area between them.

    The node triggers the steps itself, so it keeps pace on any machine.
    """
    path = tmp_path / "run.mcap"
    options = ("--paused", "--record", path, "--record-topic", "sonar_ping")
    with (
        master(tmp_path) as environment,
        programs.greeted("serve", "lake", *options, *NODE, env=environment),
    ):
        found = json.loads(run_node(MOW, environment, str(LENGTH_M), str(SPACING_M), str(LANES)))
    corner, ahead, left = map(np.array, found["corners"])
    along, across = np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9)
    grid = np.array([corner + a * (ahead - corner) + b * (left - corner) for a in along for b in across])
    track = np.array(found["track"])
    gaps_m = np.linalg.norm(grid[:, None] - track[None], axis=2).min(axis=1)
    assert gaps_m.max() < 0.5 * SPACING_M + 0.6, gaps_m.reshape(9, 9)
    assert abs(found["ros_s"] - found["stamp_s"]) < 0.5, "ROS's time is the simulator's"
    occupancy, pings = live_map(recording.open(path))
    mapped = occupancy.occupied_voxels()[:, :2]
    holes_m = np.linalg.norm(grid[:, None] - mapped[None], axis=2).min(axis=1)
    assert pings > 100 and holes_m.max() < 0.5


HEAR = """
import json, rospy, time
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage
rospy.init_node("listener", anonymous=True)
heard, latched = [], []
rospy.Subscriber("/scan", LaserScan, lambda m: heard.append((m.header.stamp.to_nsec(), list(m.ranges))))
rospy.Subscriber("/tf_static", TFMessage, lambda m: latched.append(len(m.transforms)))
until = time.time() + 60
while (len(heard) < 3 or not latched) and time.time() < until:
    time.sleep(0.02)
print(json.dumps([heard, latched, rospy.has_param("/use_sim_time")]))
"""


def test_a_recording_plays_to_rospy(tmp_path: Path, programs: Programs) -> None:
    path = tmp_path / "run.mcap"
    sim = Simulator("pool", seed=3)
    with Recorder(sim, path, topics=["scan", "tf_static"]):
        sim.advance(4.0)
    with (
        master(tmp_path) as environment,
        programs.greeted("replay", path, "--as-topics", "--wait", *NODE, env=environment) as (_, greeting),
    ):
        assert f"ROS 1 at {environment['ROS_MASTER_URI']}" in greeting
        heard, latched, uses_sim_time = json.loads(run_node(HEAR, environment))
    said = {recorded.time_ns: recorded.message for recorded in recording.open(path).messages("scan")}
    assert len(heard) >= 3
    for time_ns, ranges in heard:
        np.testing.assert_array_equal(np.float32(ranges), said[time_ns].ranges)
    assert latched == [len(next(recording.open(path).messages("tf_static")).message.transforms)]
    assert not uses_sim_time  # there is no /clock, for which nodes would wait


SERVICES = """
import genpy, json, rospy, struct, time
from geometry_msgs.msg import Pose, Twist
from rosgraph_msgs.msg import Log
from std_msgs.msg import String
rospy.init_node("caller", anonymous=True)
def request(kind, fields):
    class Request(genpy.Message):
        _type, _md5sum, _full_text, _has_header = kind + "Request", "x", "", False
        __slots__, _slot_types = fields, ("bool",) * len(fields)
        def serialize(self, buff): buff.write(bytes(getattr(self, name) for name in fields))
        def deserialize(self, data): return self
    return Request
class Answer(genpy.Message):
    _type, _md5sum, _full_text, _has_header = "std_srvs/Answer", "x", "", False
    __slots__, _slot_types = ("success", "message"), ("bool", "string")
    def __init__(self, *a, **k): self.success, self.message = False, ""
    def serialize(self, buff): pass
    def deserialize(self, data):
        self.success, self.message = bool(data[0]), data[5:].decode()
        return self
class Trigger:
    _type, _md5sum = "std_srvs/Trigger", "937c9679a518e3a18d831e57125ea522"
    _request_class, _response_class = request(_type, ()), Answer
class SetBool:
    _type, _md5sum = "std_srvs/SetBool", "09fb03525b03e7ea1fd3992bafd87e16"
    _request_class, _response_class = request(_type, ("data",)), Answer
said, until = [], time.time() + 60
rospy.Subscriber("/rosout", Log, lambda m: said.append(m.msg))
def reply(publisher, message, words):
    found = []
    while not found and time.time() < until:
        publisher.publish(message)
        time.sleep(0.1)
        found = [text for text in said if words in text]
    return found[:1]
rospy.wait_for_service("/undock", 60)
first, second = rospy.ServiceProxy("/undock", Trigger)(), rospy.ServiceProxy("/undock", Trigger)()
pace = reply(rospy.Publisher("/simulation/pace", String, queue_size=1), "{}", "factor")
twist, ahead, key = Twist(), Pose(), rospy.Publisher("/key", Pose, queue_size=1)
twist.linear.x, ahead.position.x = float("nan"), 1.0
bad = reply(rospy.Publisher("/cmd_vel", Twist, queue_size=1), twist, "cmd_vel")
stop = rospy.ServiceProxy("/all_stop", SetBool)
stopped, refusals, released = stop(True).success, reply(key, ahead, "all stop is set"), stop(False).success
key.publish(Pose())
print(json.dumps([first.success, second.success, second.message, pace, bad, stopped, refusals, released]))
"""


def test_services_are_std_srvs_and_others_take_json_and_what_is_refused_is_said(ros: dict[str, str]) -> None:
    first, second, why, pace, bad, stopped, refusals, released = json.loads(run_node(SERVICES, ros))
    assert first is True and second is False and "is not docked" in why
    assert pace and "must be finite" in bad[0]
    assert stopped and released
    assert refusals == [f"/key: vehicle 'rov': set_effort: {STOPPED}"]


PUSH = """
import json, rosgraph, rospy, time
from geometry_msgs.msg import Wrench
from std_msgs.msg import String
rospy.init_node("pusher")
parameters = rospy.Publisher("simulation/set_parameters", String, queue_size=1, latch=True)
push = rospy.Publisher("cmd_wrench", Wrench, queue_size=1)
parameters.publish(json.dumps({"values_json": json.dumps({"rov.command_timeout_s": 1e6})}))
while not (push.get_num_connections() and parameters.get_num_connections()):
    time.sleep(0.02)
wrench = Wrench()
wrench.force.x = 50.0
for _ in range(20):
    push.publish(wrench)
    time.sleep(0.05)
print(dict(rosgraph.Master("/x").getSystemState()[0])["/auv_1/scan"])
"""


def test_a_publisher_that_exits_ends_its_command_and_a_namespace_is_that_of_the_node(
    ros: dict[str, str], tmp_path: Path, programs: Programs
) -> None:
    path = tmp_path / "run.mcap"
    options = ("--namespace", "auv_1", "--record", path, "--record-topic", "clock")
    with programs.greeted("serve", "pool", *options, *NODE, env=ros):
        assert run_node(PUSH, {**ros, "ROS_NAMESPACE": "auv_1"}).strip() == "['/auv_1/uwsim']"
        time.sleep(1.0)
    pushes = [command for command in recording.open(path).commands() if command.name == "set_wrench"]
    forces_n = [command.arguments["force_body_n"][0] for command in pushes]
    assert forces_n.count(50.0) > 0 and forces_n[-1] == 0.0, "though it could have been silent for 10^6 s"


def test_connections_that_send_nothing_delay_no_subscriber(ros: dict[str, str]) -> None:
    """rospy reads connection headers one at a time, for up to 10 s each: ten half-open ones used to block for 100 s."""
    script = """
import rosgraph, rospy, socket
from xmlrpc.client import ServerProxy
from std_msgs.msg import String
rospy.init_node("late", anonymous=True)
publishers = dict(rosgraph.Master("/late").getSystemState()[0])["/depthArray"]
node = ServerProxy(rosgraph.Master("/late").lookupNode(publishers[0]))
_, host, port = node.requestTopic("/late", "/depthArray", [["TCPROS"]])[2]
silent = [socket.create_connection((host, port)) for _ in range(10)]
print(len(rospy.wait_for_message("/depthArray", String, 50).data) > 100)
"""
    assert run_node(script, ros).strip() == "True"


def test_without_a_master_it_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")
    line = error_line(uwsim("serve", "pool", "--ros1", "--port", "0"))
    assert "no master answers at http://127.0.0.1:9: start roscore" in line


def test_bytes_of_ros_1_come_back_as_messages_and_damaged_ones_are_refused() -> None:
    twist = message("geometry_msgs/msg/Twist", linear=message("geometry_msgs/msg/Vector3", x=1.5))
    data = to_bytes(twist, ros=1)
    assert read_message(data, "geometry_msgs/msg/Twist").linear.x == 1.5
    values = message("std_msgs/msg/Float64MultiArray", data=np.array([0.5, -1.0]))
    assert read_message(to_bytes(values, ros=1), "std_msgs/msg/Float64MultiArray").data.tolist() == [0.5, -1.0]
    with pytest.raises(ValueError, match="bytes that are not a valid serialisation of it"):
        read_message(data[:-3], "geometry_msgs/msg/Twist")
    assert (
        ros1_typestore().generate_msgdef("geometry_msgs/msg/Twist", ros_version=1)[1]
        == "9f195f881246fdfa2798d1d3eebca84a"
    )
