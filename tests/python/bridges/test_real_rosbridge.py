"""A rosbridge_server accepts what we send: a strict stand-in, and rosbridge_library where it is installed."""

import json
import logging
import math
import re
import subprocess
from collections.abc import Iterator
from typing import Any

import numpy as np
import orjson
import pytest

from ros1_tools import PYTHON
from strict_rosbridge import StrictRosbridge, strict_rosbridge
from uwsim.bridges import RosbridgeClient
from uwsim.bridges.rosbridge.encoding import publication
from uwsim.channels import Channel, Table
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator
from waiting import until

HAS_LIBRARY = "import rospy; from rosbridge_library.internal import message_conversion, ros_loader"


GENERATIONS = [(1, True), (1, False), (2, True), (2, False)]


@pytest.fixture
def server() -> Iterator[StrictRosbridge]:
    with strict_rosbridge() as server:
        yield server


@pytest.fixture(params=GENERATIONS, ids=lambda found: f"ros{found[0]}{'' if found[1] else ' without rosapi'}")
def any_server(request: pytest.FixtureRequest) -> Iterator[StrictRosbridge]:
    ros, rosapi = request.param
    with strict_rosbridge(ros, rosapi=rosapi) as server:
        yield server


def wait_for(server: StrictRosbridge, topic: str, more: int) -> None:
    """Return when the server has received that many more messages on a topic."""
    enough = len(server.published.get(topic, [])) + more
    server.wait(lambda: len(server.published.get(topic, [])) >= enough)


def scan(*ranges: float) -> Any:
    return build.message("sensor_msgs/msg/LaserScan", range_max=math.inf, ranges=np.array(ranges, np.float32))


def test_numbers_that_json_lacks_are_words_and_all_others_are_as_before() -> None:
    ranges = [1.1, math.nan, math.inf, -math.inf, 1e-30]
    text = publication(scan(*ranges), "/scan", 1)
    read = json.loads(text)["msg"]
    np.testing.assert_array_equal(np.float32(read["ranges"]), np.float32(ranges))
    assert read["range_max"] == math.inf and "null" not in text
    finite = publication(scan(1.1, 2.2), "/scan", 1)
    assert json.loads(finite)["msg"]["ranges"] == orjson.loads(finite.replace("Infinity", "0"))["msg"]["ranges"]


def test_connect_sends_every_scan_and_reports_what_the_server_refuses(
    server: StrictRosbridge, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING, "uwsim.rosbridge")
    with LiveSimulator("pool", speed=4.0) as live:
        table = Table(live.simulator)
        wanted = {"odom", "imu", "battery_state", "telemetry", "altitude"}
        sent = [channel for channel in table.channels if channel.name in wanted]
        kind = "sensor_msgs/msg/LaserScan"
        sent.append(Channel("scan", kind, "out", "", rate_hz=50.0, read=lambda sim: scan(1.0, math.inf, math.nan)))
        with RosbridgeClient(live, server.url, channels=sent, services=table.services):
            server.wait(lambda: len(server.published.get("scan", [])) >= 10)
            server.wait(lambda: {"odom", "imu", "battery_state", "altitude"} <= server.published.keys())
            server.wait(lambda: any("refuses" in line for line in caplog.messages))
            wait_for(server, "scan", 10)  # the last of them was sent after what was under way
            refused = len(server.refused)
            wait_for(server, "scan", 50)
            assert len(server.refused) == refused, "no message on a topic known to be refused"
    np.testing.assert_array_equal(server.published["scan"][0]["ranges"], [1.0, math.inf, math.nan])
    assert math.isnan(server.published["battery_state"][0]["voltage"])
    lacks = "Unable to load the manifest for package uwsim_msgs"
    others = [line for line in server.refused if lacks not in line and "/telemetry" not in line]
    assert server.refused and not others, "only types of packages that it lacks"
    assert server.services["/undock"] == "std_srvs/Trigger" and server.services["/all_stop"] == "std_srvs/SetBool"
    (line,) = [line for line in caplog.messages if "refuses" in line]
    assert re.search(
        r"the server refuses (/[\w/]+, ){2}/[\w/]+ and \d+ more: it lacks the package uwsim_msgs, which", line
    )


def test_a_server_of_either_generation_is_asked_and_takes_all_it_is_sent(
    any_server: StrictRosbridge, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO, "uwsim.rosbridge")
    server = any_server
    with LiveSimulator("pool", speed=4.0) as live:
        table = Table(live.simulator)
        wanted = {"clock", "odom", "imu", "tf", "camera/front/camera_info", "cmd_vel"}
        sent = [channel for channel in table.channels if channel.name in wanted]
        services = [service for service in table.services if service.name == "undock"]
        for _ in range(2):  # the second time, the server knows the services already
            with RosbridgeClient(live, server.url, channels=sent, services=services) as client:
                client.connected.wait(60.0)
                for topic in ("odom", "imu", "tf"):
                    wait_for(server, topic, 5)
                assert not client.client.is_refused and client.refusals == ""
    assert not [line for line in server.refused if "rosapi" not in line]
    assert caplog.text.count(f": connected, to ROS {server.ros}") == 2
    assert not [line for line in caplog.messages if "refuse" in line or "does not show" in line]
    assert server.types["odom"] == ("nav_msgs/Odometry" if server.ros == 1 else "nav_msgs/msg/Odometry")
    assert server.parameters == ({"/use_sim_time": "true"} if (server.ros, server.has_rosapi) == (1, True) else {})


@pytest.mark.parametrize("reason", ["it lacks the package sensor_msgs", "does not have a field scan.ranges"])
def test_a_server_that_refuses_everything_is_not_called_connected(
    server: StrictRosbridge, caplog: pytest.LogCaptureFixture, reason: str
) -> None:
    caplog.set_level(logging.INFO, "uwsim.rosbridge")
    if "package" in reason:
        server.packages.discard("sensor_msgs")
    else:
        server.lacks.add("ranges")
    channel = Channel("scan", "sensor_msgs/msg/LaserScan", "out", "", rate_hz=50.0, read=lambda sim: scan(1.0))
    with LiveSimulator("pool") as live, RosbridgeClient(live, server.url, channels=[channel]) as client:
        until(lambda: client.client.is_refused, "a refusal")
        assert reason in client.client.trouble and not client.connected.is_set() and client.connections == 0
    assert ": connected" not in caplog.text


def test_refused_messages_are_reported_at_once_and_counted_and_not_sent_for_ever(
    server: StrictRosbridge, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING, "uwsim.rosbridge")
    server.lacks = {"ranges"}
    with LiveSimulator("pool", speed=4.0) as live:
        clock = [channel for channel in Table(live.simulator).channels if channel.name == "clock"]
        kind = "sensor_msgs/msg/LaserScan"
        scans = Channel("scan", kind, "out", "", rate_hz=50.0, read=lambda sim: scan(1.0))
        with RosbridgeClient(live, server.url, channels=[*clock, scans]) as client:
            server.wait(lambda: len(server.published.get("clock", [])) >= 100)
            until(lambda: "refuses /scan" in client.refusals, "the summary")
            assert client.connected.is_set()
    refused = len([line for line in server.refused if "scan.ranges" in line])
    assert refused < 20, "those that were under way"
    (first,) = [line for line in caplog.messages if "a message on /scan is refused" in line]
    assert "does not have a field scan.ranges" in first
    assert f"has refused {refused} messages, on /scan" in caplog.messages[-1]


LIBRARY = """
import json, sys
import rospy
from rosbridge_library.internal import message_conversion, ros_loader
for line in sys.stdin:
    kind, frame = line.split(" ", 1)
    message = json.loads(frame)["msg"]
    try:
        instance = ros_loader.get_message_instance(kind)
    except ros_loader.InvalidPackageException:
        continue
    made = message_conversion.populate_instance(message, instance)
    print(made._type, [repr(value) for value in getattr(made, "ranges", [])][:4])
"""


def test_rosbridge_library_itself_accepts_all_standard_messages() -> None:
    found = subprocess.run([PYTHON, "-c", HAS_LIBRARY], capture_output=True, check=False)
    if found.returncode != 0:
        pytest.skip("Debian's Python lacks rosbridge_library or rospy")
    sim = Simulator("pool")
    sim.advance(2.0)
    lines = ["sensor_msgs/LaserScan " + publication(scan(math.inf, math.nan, 1.0), "scan", 1)]
    for channel in Table(sim).channels:
        package, *_, name = channel.type.split("/")
        message = channel.read(sim) if channel.direction == "out" and not channel.delivery.late else None
        if message is not None and package in ("geometry_msgs", "nav_msgs", "sensor_msgs", "std_msgs", "tf2_msgs"):
            lines.append(f"{package}/{name} {publication(message, channel.name, 1)}")
    done = subprocess.run([PYTHON, "-c", LIBRARY], input="\n".join(lines), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    made = done.stdout.splitlines()
    assert "['inf', 'nan', '1.0']" in made[0] and len(made) > 5, "of those packages that are installed"
